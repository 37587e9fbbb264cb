// Report of every step, for people and for programs.
#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/project/frame_times.h"
#include "capture/project/photo_facts.h"
#include "capture/relit/relit_work.h"
#include "capture/report/report_sections.h"
#include "capture/unlighting/unlight_report.h"
#include "libcommon/core/printable.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/output/html_page.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

std::string percent(const std::optional<double>& share) { return share ? fixed_percent_text(*share) : "-"; }
std::string micrometers(const std::optional<double>& mm) {
  return mm && std::isfinite(*mm) ? short_number_text(rounded(1000.0 * *mm, 3)) : "-";
}

Json matrix_json(const RigidTransform& transform) {
  const Eigen::Matrix4d m = transform.matrix();
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

RigidTransform transform_of(const Json& rows) {
  Eigen::Matrix4d matrix;
  for (Eigen::Index r = 0; r < 4; ++r) {
    for (Eigen::Index c = 0; c < 4; ++c)
      matrix(r, c) = rows.at(static_cast<std::size_t>(r)).at(static_cast<std::size_t>(c)).get<double>();
  }
  return {matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>()};
}

/// JSON has no NaN: null.
double number_of(const Json& json) {
  return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

Json registration_json(const RelitRegistration& r) {
  return {{"rms_mm", r.rms_mm},
          {"registration_overlap", r.overlap},
          {"pairs", r.num_pairs},
          {"found_by_search", r.is_found_by_search},
          {"stddev_deg", r.stddev_deg},
          {"stddev_mm", r.stddev_mm},
          {"staying", r.staying},
          {"ambiguous_deg", r.ambiguous_deg},
          {"unconstrained_dofs", r.unconstrained_dofs}};
}

/// @param json  May have other members, too. @returns nothing where it has none of these.
std::optional<RelitRegistration> registration_of(const Json& json) {
  if (!json.contains("rms_mm")) return std::nullopt;
  return RelitRegistration{.rms_mm = number_of(json.at("rms_mm")),
                           .overlap = number_of(json.at("registration_overlap")),
                           .num_pairs = json.at("pairs").get<int>(),
                           .is_found_by_search = json.at("found_by_search").get<bool>(),
                           .stddev_deg = number_of(json.at("stddev_deg")),
                           .stddev_mm = number_of(json.at("stddev_mm")),
                           .staying = json.at("staying").get<double>(),
                           .ambiguous_deg = json.value("ambiguous_deg", 0.0),
                           .unconstrained_dofs = json.value("unconstrained_dofs", std::vector<std::string>{})};
}

void put_solution(Json& json, const RelitSolution& solution) {
  json["lights"] = Json::array();
  for (const RelitLight& light : solution.lights) {
    Json entry = Json::object();
    for (std::size_t state = 1; state < kNumSampleStates; ++state)
      entry[sample_state_name(static_cast<SampleState>(state))] = light.shares[state];
    entry["residual"] = light.residual;
    json["lights"].push_back(std::move(entry));
  }
  json["residual"] = solution.residual;
  json["noise_scale"] = solution.noise_scale;
  json["notes"] = solution.notes;
}

RelitSolution solution_from_json(const Json& json) {
  RelitSolution solution{.residual = number_of(json.at("residual")),
                         .noise_scale = number_of(json.at("noise_scale")),
                         .notes = json.at("notes").get<std::vector<std::string>>()};
  for (const Json& entry : json.at("lights")) {
    RelitLight light{.residual = number_of(entry.at("residual"))};
    for (std::size_t state = 1; state < kNumSampleStates; ++state)
      light.shares[state] = number_of(entry.at(sample_state_name(static_cast<SampleState>(state))));
    solution.lights.push_back(light);
  }
  return solution;
}

RelitFrame frame_of(const Json& json) {
  RelitFrame frame{.seen_share = number_of(json.at("seen_share")),
                   .determined_share = number_of(json.at("determined_share"))};
  if (json.contains("overlap"))
    frame.overlap = number_of(json.at("overlap")), frame.offset_mm = number_of(json.at("offset_mm"));
  if (!json.contains("lights")) return frame;
  for (const Json& g : json.at("gains"))
    frame.gains.emplace_back(number_of(g.at(0)), number_of(g.at(1)), number_of(g.at(2)));
  frame.solution = solution_from_json(json);
  return frame;
}

void add_step(HtmlPage& page, const RelitWork& work, std::size_t index, const RelitStepFacts& facts) {
  page.heading("Step " + std::to_string(facts.step) + ", time " + short_number_text(facts.time) + " " +
               shown_time_unit(work.project.time_unit));
  if (!facts.frame) {
    page.paragraph("Excluded: " + facts.pose.status + ".");
    return;
  }
  page.pictures({{relit_picture_file("light", index).generic_string(), "Under the first light, in the reference view"},
                 {relit_picture_file("albedo", index).generic_string(), "Albedo"},
                 {relit_picture_file("stddev", index).generic_string(),
                  "Its standard deviation, in percent of the color: dark blue 0, yellow 10 % and more; gray: no "
                  "surface; red: not determined"}});
  page.picture({relit_picture_file("samples", index).generic_string(),
                "Samples: light gray used, black facing away, blue cast shadow, magenta saturated or out of view, cyan "
                "too dark, red too bright"});
  if (!facts.frame->solution) return;
  std::vector<std::vector<std::string>> rows;
  const std::vector<RelitLight>& lights = facts.frame->solution->lights;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    std::string gain = "-";
    if (i < facts.frame->gains.size()) {
      const Vec3& g = facts.frame->gains[i];
      gain = short_number_text(rounded(g.x(), 4)) + " " + short_number_text(rounded(g.y(), 4)) + " " +
             short_number_text(rounded(g.z(), 4));
    }
    const auto share = [&](SampleState state) { return percent(lights[i].shares[static_cast<std::size_t>(state)]); };
    rows.push_back({std::to_string(i), share(SampleState::Clean), share(SampleState::Unlit),
                    share(SampleState::CastShadow), share(SampleState::Invalid), share(SampleState::Darker),
                    share(SampleState::Brighter), percent(lights[i].residual), gain});
  }
  page.table({"light", "used", "facing away", "cast shadow", "saturated", "too dark", "too bright", "residual",
              "gain by the patch"},
             rows);
  for (const std::string& note : facts.frame->solution->notes) page.paragraph(note);
}

/// The frames of the history, and the steps' notes as warnings of them.
ReportSeries series_of(const HistoryManifest& history, const RelitWork& work, const fs::path& folder,
                       const std::vector<RelitStepFacts>& facts, const ImageU8& mask, const RunControl& control) {
  ReportSeries series{.one = "step",
                      .masked = "in shadow, saturated, hidden or turned away",
                      .unseen = "",
                      .unit = shown_time_unit(work.project.time_unit),
                      .warnings = history.warnings};
  for (const RelitStepFacts& f : facts) {
    const std::string name = "step " + std::to_string(f.step);
    const auto warn = [&](const std::string& text, double share) {
      series.warnings.push_back({.text = name + text, .cure = "", .share = share, .photos = {name}});
    };
    if (!f.frame) {
      warn(" is excluded: " + f.pose.status, 1.0);
      continue;
    }
    series.names.push_back(name);
    series.times.push_back(f.time);
    if (!f.frame->solution) continue;
    for (const std::string& note : f.frame->solution->notes) warn(": " + note, 0.0);
  }
  sort_warnings(series.warnings);
  series.time_labels = short_number_texts(series.times);
  series.look = look_at_frames(history, folder, mask, shown_frames(named_by_warnings(series)), {}, control);
  return series;
}

/// Adds what every photograph's file says.
void add_files(HtmlPage& page, const RelitWork& work) {
  std::vector<std::pair<std::string, ImageFacts>> all;
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const RelitStep& step, const fs::path& file, const std::string& light) {
    const ImageInfo info = probe_image(file);
    const std::string name = printable_line(file.lexically_relative(work.project.file.parent_path()).string());
    all.emplace_back(name, info.facts);
    const std::string exposure = exposure_text(info.exposure), time = photo_time_text(file, info);
    rows.push_back({name, std::to_string(step.number), light, size_text(info.width, info.height),
                    exposure.empty() ? "-" : exposure, time.empty() ? "-" : time});
  };
  for (const RelitStep& step : work.project.steps) {
    for (std::size_t i = 0; i < step.photos.size(); ++i) add(step, step.photos[i], std::to_string(i));
    if (step.ambient) add(step, *step.ambient, "all off");
    if (step.ready) add(step, step.ready->albedo, "ready albedo");
  }
  page.heading("Files");
  const std::vector<std::vector<std::string>> said = fact_rows(all);
  if (said.empty())
    page.paragraph(
        "The photographs say nothing of how they are to be seen: codes are sRGB unless `response` says "
        "otherwise, floats are linear light (Rec. 709).");
  else
    page.table({"of", "the photographs"}, said);
  page.table({"photograph", "step", "light", "size", "exposure", "the file's time"}, rows);
}

}  // namespace

Json to_json(const RelitPose& pose) {
  return {{"status", pose.status},
          {"is_accepted", pose.is_accepted},
          {"is_joint", pose.is_joint},
          {"reference_from_scan", matrix_json(pose.reference_from_scan)},
          {"facts", pose.registration ? registration_json(*pose.registration) : Json::object()}};
}

RelitPose relit_pose(const Json& json) {
  return {json.at("status").get<std::string>(), json.at("is_accepted").get<bool>(),
          transform_of(json.at("reference_from_scan")), registration_of(json.at("facts")),
          json.at("is_joint").get<bool>()};
}

Json to_json(const RelitStepFacts& facts) {
  Json json{{"step", facts.step},
            {"time", facts.time},
            {"status", facts.pose.status},
            {"solved_jointly", facts.pose.is_joint},
            {"in_history", facts.frame.has_value()},
            {"reference_from_scan", matrix_json(facts.pose.reference_from_scan)}};
  if (facts.pose.registration) json.update(registration_json(*facts.pose.registration));
  if (!facts.frame) return json;
  const RelitFrame& frame = *facts.frame;
  if (frame.overlap) json["overlap"] = *frame.overlap, json["offset_mm"] = frame.offset_mm.value_or(0.0);
  if (frame.solution) {
    json["gains"] = Json::array();
    for (const Vec3& g : frame.gains) json["gains"].push_back({g.x(), g.y(), g.z()});
    put_solution(json, *frame.solution);
  }
  json["seen_share"] = frame.seen_share;
  json["determined_share"] = frame.determined_share;
  return json;
}

RelitStepFacts relit_step_facts(const Json& json) {
  const bool is_accepted = json.at("in_history").get<bool>();
  RelitStepFacts facts{
      .step = json.at("step").get<int>(),
      .time = json.at("time").get<double>(),
      .pose = {json.at("status").get<std::string>(), is_accepted, transform_of(json.at("reference_from_scan")),
               registration_of(json), json.at("solved_jointly").get<bool>()}};
  if (is_accepted) facts.frame = frame_of(json);
  return facts;
}

void write_relit_report(const HistoryManifest& history, const RelitWork& work, const fs::path& folder,
                        const std::vector<RelitStepFacts>& facts, const ImageU8& mask, const RunControl& control) {
  Json json{{"format", "patinate.relit"}, {"version", 2}, {"steps", Json::array()}};
  for (const RelitStepFacts& f : facts) json["steps"].push_back(to_json(f));
  save_json(folder / kRelitReportFile, json);
  HtmlPage page(work.project.name + ": a shape through time");
  page.paragraph(std::to_string(facts.size()) + " steps, " + std::to_string(work.project.lights.size()) + " lights, " +
                 size_text(work.project.width(), work.project.height()) +
                 " pixels. Everything is shown in the view of step " +
                 std::to_string(work.project.steps[work.project.reference].number) + ".");
  const ReportSeries series = series_of(history, work, folder, facts, mask, control);
  add_warnings(page, series);
  page.heading("Steps as they were solved");
  std::vector<std::vector<std::string>> rows;
  std::vector<HtmlPicture> albedos;
  for (std::size_t i = 0; i < facts.size(); ++i) {
    const RelitStepFacts& f = facts[i];
    const RelitFrame frame = f.frame.value_or(RelitFrame{});
    const auto of_frame = [&](double share) { return f.frame ? std::optional(share) : std::nullopt; };
    const std::string time = short_number_text(f.time);
    rows.push_back({std::to_string(f.step), time, f.pose.status + (f.pose.is_joint ? ", jointly" : ""),
                    micrometers(f.pose.registration ? std::optional(f.pose.registration->rms_mm) : std::nullopt),
                    micrometers(frame.offset_mm), percent(frame.overlap), percent(of_frame(frame.seen_share)),
                    percent(of_frame(frame.determined_share)),
                    percent(frame.solution ? std::optional(frame.solution->residual) : std::nullopt)});
    if (f.frame)
      albedos.push_back(
          {relit_picture_file("albedo", i).generic_string(), time + " " + shown_time_unit(work.project.time_unit)});
  }
  page.table({"step", "time", "registration", "RMS (um)", "off the reference (um)", "overlap", "seen", "determined",
              "residual of the light"},
             rows);
  if (!albedos.empty()) page.time_slider(albedos, "Albedo over time");
  add_color_curves(page, series);
  add_pictures(page, series, mask, history.width, history.height);
  add_controls(page, history, folder, mask);
  for (std::size_t i = 0; i < facts.size(); ++i) add_step(page, work, i, facts[i]);
  add_table(page, series, color_columns(series));
  add_files(page, work);
  page.link(kRelitReportFile, "The same as JSON");
  page.save(folder / kIngestPageFile);
}

}  // namespace patinate::capture
