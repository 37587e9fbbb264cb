#include "capture/timelapse/ingest_report.h"

#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/project/given_transforms.h"
#include "capture/project/photo_facts.h"
#include "capture/report/report_sections.h"
#include "capture/timelapse/align_step.h"
#include "capture/timelapse/chart_report.h"
#include "capture/timelapse/ingest_warnings.h"
#include "capture/timelapse/repair_steps.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/output/svg_chart.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

using Rows = std::vector<std::vector<std::string>>;

/// Records of a step of the ingest about every photograph, by its number; empty where it did not run.
std::map<int, Json> by_number(const Json& photos) {
  std::map<int, Json> found;
  for (const Json& photo : photos) found[photo.at("number").get<int>()] = photo;
  return found;
}

/// Everything about photographs that earlier steps wrote.
struct PhotoNotes {
  std::map<int, Json> alignment, registered, patch;
  std::map<int, std::vector<std::string>> findings;
  Json chart;                    ///< Chart as read_chart() gives it.
  Json factors = Json::array();  ///< Factors of --deflicker; a frame each, or none.
  std::string reference;         ///< Reference of the alignment.
};

PhotoNotes read_notes(const IngestWork& work, const fs::path& folder, const SurveyReport& survey) {
  PhotoNotes notes;
  if (needs_alignment(work)) {
    const Json alignment = load_json(folder / kAlignmentFile);
    notes.alignment = by_number(alignment.at("photos"));
    notes.reference = alignment.at("reference").get<std::string>();
  }
  for (const SurveyFinding& finding : survey.findings) {
    std::vector<std::string>& found = notes.findings[finding.photo.number];
    for (const SurveyProblem* problem : {&finding.moved, &finding.exposed, &finding.unclear, &finding.jump}) {
      // Photographs that were aligned with others are not said to fit none of them.
      const bool is_overruled = problem->size >= kUnmatchedSize && work.project.is_handheld();
      if (!problem->text.empty() && !is_overruled) found.push_back(problem->text);
    }
  }
  for (const SurveyOutsider& outsider : survey.unlinked) {
    if (!work.project.is_handheld())
      notes.findings[outsider.photo.number].push_back("cannot be aligned with the others");
  }
  const Json json = fs::exists(folder / kSurveyFile) ? load_json(folder / kSurveyFile) : Json::object();
  if (json.contains("frames")) notes.registered = by_number(json.at("frames"));
  if (json.contains("reference_patch")) notes.patch = by_number(json.at("reference_patch"));
  notes.chart = read_chart(folder);
  if (json.contains("factors")) notes.factors = json.at("factors");
  return notes;
}

/// A column whose cells are made of the photographs.
ReportColumn column(const CaptureProject& project, std::string title,
                    const std::function<std::string(const CapturePhoto&, std::size_t)>& cell_of) {
  ReportColumn made{std::move(title), {}};
  for (std::size_t i = 0; i < project.frames.size(); ++i) made.cells.push_back(cell_of(project.frames[i], i));
  return made;
}

/// Column that is empty where all cells are alike: the page says such things once.
ReportColumn differing(ReportColumn made) {
  const bool is_one = std::all_of(made.cells.begin(), made.cells.end(),
                                  [&](const std::string& cell) { return cell == made.cells.front(); });
  if (is_one) std::fill(made.cells.begin(), made.cells.end(), "");
  return made;
}

/// Columns of what files say, those of which photographs differ.
void add_fact_columns(const CaptureProject& project, std::vector<ReportColumn>& columns) {
  std::vector<std::string> names;
  for (const CapturePhoto& photo : project.frames) {
    for (const auto& [name, text] : photo.facts.named()) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  for (const std::string& name : names) {
    columns.push_back(differing(column(project, name, [&](const CapturePhoto& photo, std::size_t) {
      for (const auto& [said, text] : photo.facts.named()) {
        if (said == name) return text;
      }
      return std::string("nothing said");
    })));
  }
}

std::string number_in(const std::map<int, Json>& notes, const CapturePhoto& photo, const char* member) {
  const auto found = notes.find(photo.number);
  if (found == notes.end() || !found->second.contains(member)) return "";
  return hundredths(found->second.at(member).get<double>());
}

std::string placed_text(const PhotoNotes& notes, const CapturePhoto& photo) {
  const auto aligned = notes.alignment.find(photo.number);
  if (aligned != notes.alignment.end()) {
    std::string text = aligned->second.at("status").get<std::string>();
    if (aligned->second.contains("through")) text += " (" + aligned->second.at("through").get<std::string>() + ")";
    return text;
  }
  const auto registered = notes.registered.find(photo.number);
  if (registered != notes.registered.end()) return registered->second.at("status").get<std::string>();
  return photo.transform ? "given" : "";
}

std::string factors_text(const Json& factors) {
  std::string text;
  for (const Json& factor : factors) text += (text.empty() ? "" : " ") + hundredths(factor.get<double>());
  return text;
}

std::string light_text(const PhotoNotes& notes, const CapturePhoto& photo, std::size_t index) {
  const auto patch = notes.patch.find(photo.number);
  if (patch != notes.patch.end() && patch->second.contains("factors")) return factors_text(patch->second.at("factors"));
  return index < notes.factors.size() ? factors_text(notes.factors.at(index)) : "";
}

std::vector<ReportColumn> photo_columns(const IngestWork& work, const PhotoNotes& notes, const ReportSeries& series) {
  const CaptureProject& project = work.project;
  std::vector<ReportColumn> columns;
  const auto add = [&](const char* title, const std::function<std::string(const CapturePhoto&, std::size_t)>& cell_of) {
    columns.push_back(column(project, title, cell_of));
  };
  add("number", [](const CapturePhoto& photo, std::size_t) { return std::to_string(photo.number); });
  add("time", [&](const CapturePhoto&, std::size_t i) { return time_text(series, i); });
  add("the file's time", [](const CapturePhoto& photo, std::size_t) { return photo.said_time; });
  columns.push_back(differing(column(
      project, "size", [](const CapturePhoto& photo, std::size_t) { return size_text(photo.width, photo.height); })));
  add_fact_columns(project, columns);
  add("exposure", [](const CapturePhoto& photo, std::size_t) { return exposure_text(photo.exposure); });
  add("aligned with", [&](const CapturePhoto& photo, std::size_t) { return placed_text(notes, photo); });
  add("residual (px)", [&](const CapturePhoto& photo, std::size_t) {
    return number_in(notes.alignment.empty() ? notes.registered : notes.alignment, photo, "residual_px");
  });
  add("pixels for one of the reference's", [&](const CapturePhoto& photo, std::size_t) {
    return number_in(notes.alignment, photo, "pixels_per_reference_pixel");
  });
  add("shows of the reference", [&](const CapturePhoto& photo, std::size_t) {
    const auto found = notes.alignment.find(photo.number);
    if (found == notes.alignment.end() || !found->second.contains("shown_share")) return std::string();
    return fixed_percent_text(found->second.at("shown_share").get<double>());
  });
  add("light times", [&](const CapturePhoto& photo, std::size_t i) { return light_text(notes, photo, i); });
  add("chart (CIEDE2000)", [&](const CapturePhoto& photo, std::size_t) {
    return notes.chart.is_null() ? "" : number_in(by_number(notes.chart.at("photos")), photo, "mean_ciede2000");
  });
  for (ReportColumn& of_color : color_columns(series)) columns.push_back(std::move(of_color));
  return columns;
}

std::string size_row(const CaptureProject& project) {
  std::map<std::string, int> counts;
  for (const CapturePhoto& photo : project.frames) ++counts[size_text(photo.width, photo.height)];
  if (counts.size() == 1) return counts.begin()->first + " pixels";
  return std::to_string(counts.size()) + " different sizes; the reference has " +
         size_text(project.photo_width, project.photo_height) + " pixels";
}

std::string times_text(const CaptureProject& project) {
  if (project.time_source == "interval" || project.time_source == "list")
    return "as the project states them (" + project.time_source + ")";
  return "from " + project.time_source + (project.time_span.empty() ? "" : ", " + project.time_span);
}

/// Rows about what was understood of the photographs and done with them, once for all.
Rows understood(const IngestWork& work, const PhotoNotes& notes, const SurveyReport& survey) {
  const CaptureProject& project = work.project;
  Rows rows{{"size", size_row(project)}};
  std::vector<std::pair<std::string, ImageFacts>> all, coded;
  for (const CapturePhoto& photo : project.frames) {
    all.emplace_back(photo.name(), photo.facts);
    if (photo.has_codes) coded.push_back(all.back());
  }
  for (std::vector<std::string>& row : fact_rows(all)) rows.push_back(std::move(row));
  const bool is_color_said = std::any_of(all.begin(), all.end(), [](const auto& p) { return !p.second.color.empty(); });
  if (!is_color_said)
    rows.push_back({"color", "nothing said: codes are sRGB, floats and camera RAW linear light (Rec. 709)"});
  if (const std::string text = override_text(coded, project.response); !text.empty())
    rows.push_back({"response", text});
  if (project.has_raw_frames) rows.push_back({"camera RAW", "linear light with daylight white balance"});
  rows.push_back({"times", times_text(project)});
  if (!project.excluded.empty()) {
    std::string numbers;
    for (const int number : project.excluded) numbers += (numbers.empty() ? "" : ", ") + std::to_string(number);
    rows.push_back({"left out", "numbers " + numbers});
  }
  if (needs_alignment(work)) {
    rows.push_back({"alignment", "`align` " + align_method_text(project.align.method) + ", over " + notes.reference});
  } else if (project.is_handheld()) {
    rows.push_back({"alignment", "by the transforms that the project gives"});
  }
  for (const std::string& note : light_notes(survey.light)) rows.push_back({"light", note});
  for (const std::string& note : chart_notes(notes.chart)) rows.push_back({"color", note});
  return rows;
}

void add_residual_curve(HtmlPage& page, const CaptureProject& project, const PhotoNotes& notes,
                        const ReportSeries& series) {
  const std::map<int, Json>& placed = notes.alignment.empty() ? notes.registered : notes.alignment;
  if (placed.empty() || project.frames.size() < 2) return;
  ChartSeries curve{.name = "residual", .x = series.times};
  for (const CapturePhoto& photo : project.frames) {
    const auto found = placed.find(photo.number);
    const bool is_known = found != placed.end() && found->second.contains("residual_px");
    curve.y.push_back(is_known ? std::optional(found->second.at("residual_px").get<double>()) : std::nullopt);
  }
  page.drawing(svg_chart({.title = "Alignment",
                          .x_label = "time (" + series.unit + ")",
                          .y_label = "residual (px of the reference)",
                          .series = {curve}}));
}

/// How exposure and white balance went, as the chart shows them.
void add_drift_curve(HtmlPage& page, const PhotoNotes& notes, const ReportSeries& series) {
  const std::vector<ChartDrift> drift = chart_drift(notes.chart);
  if (drift.size() < 2) return;
  std::vector<ChartSeries> curves{{.name = "exposure", .x = series.times},
                                  {.name = "red over green", .x = series.times},
                                  {.name = "blue over green", .x = series.times}};
  for (const ChartDrift& of_photo : drift) {
    curves[0].y.emplace_back(of_photo.exposure);
    curves[1].y.emplace_back(of_photo.red);
    curves[2].y.emplace_back(of_photo.blue);
  }
  page.drawing(svg_chart({.title = "Light by the chart, taken out",
                          .x_label = "time (" + series.unit + ")",
                          .y_label = "times that of the first photograph",
                          .series = std::move(curves)}));
}

ImageU8 unseen_part(const IngestWork& work, const fs::path& folder, int index) {
  if (!has_validity(work)) return {};
  ImageU8 codes = read_validity(folder, index);
  for (std::uint8_t& v : codes.values()) v = v == static_cast<std::uint8_t>(Validity::OutOfView) ? 255 : 0;
  return codes;
}

std::string kind_text(const CaptureProject& project) {
  if (project.frames.size() == 1) return "One photograph";
  return std::to_string(project.frames.size()) + " photographs " +
         (project.is_handheld() ? "that are aligned with each other" : "of a fixed camera");
}

}  // namespace

void write_ingest_report(const HistoryManifest& history, const IngestWork& work, const fs::path& folder,
                         const ImageU8& mask, const RunControl& control) {
  const CaptureProject& project = work.project;
  const SurveyReport survey = read_survey_report(folder);
  const PhotoNotes notes = read_notes(work, folder, survey);
  ReportSeries series{
      .names = photo_names(project.frames), .unit = shown_time_unit(project.time_unit), .warnings = history.warnings};
  sort_warnings(series.warnings);
  for (const CapturePhoto& photo : project.frames) {
    series.times.push_back(photo.time);
    const auto found = notes.findings.find(photo.number);
    series.found.push_back(found == notes.findings.end() ? std::vector<std::string>() : found->second);
  }
  series.time_labels = short_number_texts(series.times);
  series.look = look_at_frames(
      history, folder, mask, shown_frames(named_by_warnings(series)),
      [&](int i) { return unseen_part(work, folder, i); }, control);
  SeriesLight uneven;
  uneven.uneven = survey.light.uneven;
  for (const HistoryWarning& warning :
       light_warnings(uneven, work.options.repair.flat_field, static_cast<int>(project.frames.size())))
    series.places[warning.text] = light_place(series);
  HtmlPage page(project.name + ": what ingest made of the photographs");
  std::string text = kind_text(project) + (project.rig ? " under a known lamp" : "") + ", " + time_text(series, 0);
  if (series.times.size() > 1) text += " to " + time_text(series, series.times.size() - 1);
  text += ". The history has " + size_text(history.width, history.height) + " pixels";
  if (history.texel_size_mm) text += ", each " + figure_text(*history.texel_size_mm) + " mm";
  page.paragraph(text + ".");
  add_warnings(page, series);
  page.heading("What was understood");
  page.table({"of", "the photographs"}, understood(work, notes, survey));
  add_color_curves(page, series);
  add_residual_curve(page, project, notes, series);
  add_drift_curve(page, notes, series);
  add_pictures(page, series, mask, history.width, history.height);
  add_controls(page, history, folder, mask);
  add_table(page, series, photo_columns(work, notes, series));
  page.save(folder / kIngestPageFile);
}

}  // namespace patinate::capture
