#include "analysis/grading/grade_report.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/grading/grade_document.h"
#include "analysis/grading/surface_forecast.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/csv.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_card.h"
#include "libcommon/output/svg_chart.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxRows = 16;  // Most rows of the page's tables; the CSV has all times.
constexpr int kPictureSide_px = 900;

/// Names of figures for people.
struct FigureTitle {
  std::string_view name, title, unit;
};
constexpr std::array<FigureTitle, kGradedFigureNames.size()> kTitles{{{"rusted_percent", "Rusted area", "%"},
                                                                      {"blistered_percent", "Blistered area", "%"},
                                                                      {"blister_mm", "Size of blisters", "mm"},
                                                                      {"flaked_percent", "Flaked area", "%"},
                                                                      {"flake_mm", "Size of flakes", "mm"},
                                                                      {"crack_mm_per_mm2", "Cracks", "mm/mm2"},
                                                                      {"crack_width_mm", "Width of cracks", "mm"},
                                                                      {"creep_mm", "Creep, mean", "mm"},
                                                                      {"creep_max_mm", "Creep, largest", "mm"},
                                                                      {"delta_e", "Delta E*ab", ""},
                                                                      {"ciede2000", "CIEDE2000", ""},
                                                                      {"delta_l", "Delta L*", ""},
                                                                      {"delta_a", "Delta a*", ""},
                                                                      {"delta_b", "Delta b*", ""},
                                                                      {"gloss_20", "Gloss at 20 deg", "GU"},
                                                                      {"gloss_60", "Gloss at 60 deg", "GU"},
                                                                      {"gloss_85", "Gloss at 85 deg", "GU"}}};

std::string digits(double value) { return short_number_text(rounded(value, 3) + 0.0); }

std::string with_interval(const GradedFigure& f) {
  return f.low == f.high ? digits(f.value) : digits(f.value) + " (" + digits(f.low) + " to " + digits(f.high) + ")";
}

std::string grade_text(const GradeScale& scale, const RegionFigures& figures, double least) {
  const std::optional<GivenGrade> grade = grade_of(scale, figures, least);
  if (!grade) return "-";
  std::string text = grade->grade;
  if (scale.name == "d610" && !figures.distribution.empty()) text += "-" + figures.distribution;
  const auto given =
      std::find_if(scale.grades.begin(), scale.grades.end(), [&](const Grade& g) { return g.name == grade->grade; });
  if (given != scale.grades.end() && !given->word.empty()) text += " " + given->word;
  if (grade->low != grade->high) text += " (" + grade->low + " to " + grade->high + ")";
  return text;
}

bool has_figure(const GradedRegion& region, std::string_view figure) {
  return std::any_of(region.times.begin(), region.times.end(),
                     [&](const RegionFigures& t) { return t.figure(figure).has_value(); });
}

/// Indices of times that a table shows: all, or evenly chosen ones with the last.
std::vector<std::size_t> shown_rows(std::size_t count) {
  std::vector<std::size_t> rows;
  const std::size_t step = (count + kMaxRows - 1) / kMaxRows;
  for (std::size_t t = 0; t < count; t += step) rows.push_back(t);
  if (rows.back() != count - 1) rows.back() = count - 1;
  return rows;
}

std::string time_text(const GradeReport& report, double time) {
  return short_number_text(time) + "\u00a0" + time_unit_text(report.series.series.facts().time_unit);
}

void add_figure_table(HtmlPage& page, const GradeReport& report, const GradedRegion& region) {
  std::vector<std::string> header{"time"};
  std::vector<const FigureTitle*> figures;
  for (const FigureTitle& title : kTitles) {
    if (!has_figure(region, title.name)) continue;
    figures.push_back(&title);
    header.push_back(figure_title(title.name));
  }
  std::vector<std::vector<std::string>> rows;
  for (const std::size_t t : shown_rows(region.times.size())) {
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(time_text(report, report.surface.times[t]));
    for (const FigureTitle* title : figures) {
      const std::optional<GradedFigure>& figure = region.times[t].figure(title->name);
      row.push_back(figure ? with_interval(*figure) : "-");
    }
  }
  page.table(header, rows);
}

/// "Degree of rusting Ri" is "Ri" over a column.
std::string short_title(const GradeScale& scale) {
  const std::size_t at = scale.title.rfind(' ');
  const std::string last = scale.title.substr(at == std::string::npos ? 0 : at + 1);
  return last.size() == 2 ? last : scale.title;
}

void add_grade_table(HtmlPage& page, const GradeReport& report, const GradedRegion& region) {
  std::vector<std::string> header{"time"};
  std::vector<const GradeScale*> scales;
  for (const GradeScale& scale : report.rules.scales) {
    if (!has_figure(region, scale.figure)) continue;
    scales.push_back(&scale);
    header.push_back(short_title(scale) + ", " + scale.standard);
  }
  header.insert(header.end(), {"spots", "mean, mm"});
  std::vector<std::vector<std::string>> rows;
  for (const std::size_t t : shown_rows(region.times.size())) {
    const RegionFigures& figures = region.times[t];
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(time_text(report, report.surface.times[t]));
    for (const GradeScale* scale : scales) row.push_back(grade_text(*scale, figures, least_of(*scale, region)));
    row.push_back(std::to_string(figures.num_spots));
    row.push_back(figures.mean_spot_mm ? digits(*figures.mean_spot_mm) : "-");
  }
  page.table(header, rows);
}

void add_times(HtmlPage& page, const GradeReport& report, const GradedRegion& region) {
  const auto text = [&](const std::optional<double>& t) { return t ? time_text(report, rounded(*t, 3)) : "-"; };
  std::vector<std::vector<std::string>> rows;
  for (const GradeScale& scale : report.rules.scales) {
    const ExtendedSeries series = extended_series(report.surface, region, scale.figure);
    for (const GradeTime& g :
         grade_times(scale, series.times, series.figures, least_of(scale, region), report.surface.times.back())) {
      if (g.state == Reached::NotReached && !g.earliest) continue;
      rows.push_back({scale.title + " " + scale.grades[g.grade].name,
                      g.state == Reached::Reached    ? text(g.time)
                      : g.state == Reached::Forecast ? text(g.time) + ", forecast"
                                                     : std::string(kReachedNames[static_cast<std::size_t>(g.state)]),
                      text(g.earliest), text(g.latest)});
    }
  }
  if (rows.empty()) return;
  page.paragraph("Time to each grade. Between two photographs a figure is taken to rise linearly.");
  page.table({"grade", "reached", "not before", "not after"}, rows);
}

/// What is said of a law's figure.
std::string law_text(const GrowthTest& test) {
  if (test.law == GrowthLaw::Held) return "held: no law foretold it better than its last value";
  return std::string(kGrowthLawNames[static_cast<std::size_t>(test.law)]) + ", " + digits(100.0 * test.share) +
         "\u00a0% of its change";
}

void add_forecast_table(HtmlPage& page, const GradeReport& report, const GradedRegion& region) {
  if (region.forecasts.empty()) return;
  std::vector<std::vector<std::string>> rows;
  for (const FigureForecast& f : region.forecasts) {
    rows.push_back({figure_title(f.figure), with_interval(f.values.back()), law_text(f.test),
                    digits(f.test.error / f.test.held_error)});
  }
  page.paragraph(
      "Forecast at " + time_text(report, report.surface.forecast_times.back()) +
      ", with 90 % intervals. Each law was fitted to the beginning of the series and asked for the rest; the "
      "last column is its error over that of the last value held.");
  page.table({"figure", "forecast", "law", "error in tests"}, rows);
}

void add_chart(HtmlPage& page, const GradeReport& report, const GradedRegion& region) {
  if (report.surface.times.size() < 2) return;
  ChartSeries rusted{.name = "rusted area"};
  for (std::size_t t = 0; t < report.surface.times.size(); ++t) {
    const std::optional<GradedFigure>& f = region.times[t].figure("rusted_percent");
    rusted.x.push_back(report.surface.times[t]);
    rusted.y.push_back(f->value);
    rusted.band.emplace_back(f->low, f->high);
  }
  Chart chart{.title = "Rusted area and limits of Ri",
              .x_label = "time (" + time_unit_text(report.series.series.facts().time_unit) + ")",
              .y_label = "%",
              .series = {rusted}};
  double most = region.times.back().figure("rusted_percent")->high;
  for (const FigureForecast& f : region.forecasts) {
    if (f.figure != "rusted_percent") continue;
    ChartSeries ahead{.name = "forecast", .x = {rusted.x.back()}, .y = {rusted.y.back()}, .is_dashed = true};
    ahead.band.push_back(rusted.band.back());
    for (std::size_t k = 0; k < f.values.size(); ++k) {
      ahead.x.push_back(report.surface.forecast_times[k]);
      ahead.y.push_back(f.values[k].value);
      ahead.band.emplace_back(f.values[k].low, f.values[k].high);
    }
    most = std::max(most, f.values.back().high);
    chart.series.push_back(std::move(ahead));
  }
  for (const GradeScale& scale : report.rules.scales) {
    if (scale.name != "ri") continue;
    for (const Grade& grade : scale.grades) {
      if (!(grade.up_to > 0.02 * most && grade.up_to < most)) continue;
      chart.series.push_back({.name = "Ri " + grade.name + " up to here",
                              .x = {report.surface.times.front(), chart.series.back().x.back()},
                              .y = {grade.up_to, grade.up_to},
                              .is_dashed = true});
    }
  }
  page.drawing(svg_chart(chart));
}

/// The line between the ends, a pixel wide.
void draw_scribe(const Scribe& scribe, double pixel_mm, ImageF& picture) {
  constexpr std::array<float, 3> kGreen{0.1f, 0.7f, 0.1f};
  const double length = std::hypot(scribe.x1 - scribe.x0, scribe.y1 - scribe.y0);
  for (double along = 0.0; along <= length; along += 0.5 * pixel_mm) {
    const double share = along / length;
    const int x = static_cast<int>(std::floor((scribe.x0 + share * (scribe.x1 - scribe.x0)) / pixel_mm)),
              y = static_cast<int>(std::floor((scribe.y0 + share * (scribe.y1 - scribe.y0)) / pixel_mm));
    if (picture.contains(x, y)) std::copy(kGreen.begin(), kGreen.end(), picture.pixel(x, y).begin());
  }
}

/// Outlines blisters and flakes. @param labels  By pixel, -1 = none.
void draw_outlines(const std::vector<int>& labels, const std::array<float, 3>& color, ImageF& picture) {
  const auto label = [&](int x, int y) {
    return picture.contains(x, y) ? labels[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width()) +
                                           static_cast<std::size_t>(x)]
                                  : -1;
  };
  for (int y = 0; y < picture.height() && !labels.empty(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const int own = label(x, y);
      const bool is_edge = own >= 0 && (label(x - 1, y) != own || label(x + 1, y) != own || label(x, y - 1) != own ||
                                        label(x, y + 1) != own);
      if (is_edge) std::copy(color.begin(), color.end(), picture.pixel(x, y).begin());
    }
  }
}

/// The photograph with what was counted: rust's outline is magenta, that of blisters yellow and of flakes orange,
/// cracks are cyan, the scribe is green.
ImageF counted(const ShownTime& shown, const GradedSurface& surface) {
  constexpr std::array<float, 3> kMagenta{0.9f, 0.0f, 0.6f}, kCyan{0.0f, 0.6f, 0.9f};
  ImageF out = shown.color;
  const auto is_rust = [&](int x, int y) { return shown.rust.contains(x, y) && shown.rust.at(x, y) >= 0.5f; };
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const bool is_edge =
          is_rust(x, y) && !(is_rust(x - 1, y) && is_rust(x + 1, y) && is_rust(x, y - 1) && is_rust(x, y + 1));
      const bool is_crack = !shown.cracks.empty() && shown.cracks.at(x, y) != 0;
      if (is_edge) std::copy(kMagenta.begin(), kMagenta.end(), out.pixel(x, y).begin());
      if (is_crack) std::copy(kCyan.begin(), kCyan.end(), out.pixel(x, y).begin());
    }
  }
  draw_outlines(shown.marks[0], {0.9f, 0.8f, 0.0f}, out);
  draw_outlines(shown.marks[1], {0.9f, 0.3f, 0.0f}, out);
  for (const Scribe& scribe : surface.scribes) draw_scribe(scribe, *surface.pixel_mm, out);
  return out;
}

std::vector<Picture> pictures_of(const GradeReport& report) {
  std::vector<Picture> pictures;
  for (const ShownTime& shown : report.surface.shown) {
    const std::string time = time_text(report, report.surface.times[shown.time]);
    pictures.push_back({"photo", time, shown.color});
    std::string caption = time + ": rust is outlined in magenta, cracks are blue";
    if (!shown.marks[0].empty()) caption += ", blisters are outlined in yellow, flakes in orange";
    if (!report.surface.scribes.empty()) caption += ", the scribe is green";
    pictures.push_back({"counted", caption, counted(shown, report.surface)});
  }
  return pictures;
}

void add_standards(HtmlPage& page, const GradeRules& rules) {
  std::vector<std::vector<std::string>> rows;
  for (const GradeScale& scale : rules.scales) {
    rows.push_back({scale.title, scale.standard + ":" + scale.edition + ", " + scale.clause,
                    scale.is_checked ? "compared with the standard's text" : "not compared with the standard's text",
                    scale.note});
  }
  page.heading("Standards");
  page.table({"scale", "standard", "limits", "note"}, rows, true);
}

std::string csv_rows(const GradeReport& report) {
  std::string text = "region,time,name,value,low,high,unit\n";
  for (const GradedRegion& region : report.surface.regions) {
    for (std::size_t t = 0; t < region.times.size(); ++t) {
      const std::string begin = csv_cell(region.name) + "," + csv_cell(std::optional(report.surface.times[t])) + ",";
      const RegionFigures& figures = region.times[t];
      for (const FigureTitle& title : kTitles) {
        if (const std::optional<GradedFigure>& f = figures.figure(title.name))
          text += begin + std::string(title.name) + "," + csv_cell(std::optional(f->value)) + "," +
                  csv_cell(std::optional(f->low)) + "," + csv_cell(std::optional(f->high)) + "," +
                  std::string(title.unit) + "\n";
      }
      for (const GradeScale& scale : report.rules.scales) {
        if (const auto grade = grade_of(scale, figures, least_of(scale, region)))
          text += begin + scale.name + "," + grade->grade + "," + grade->low + "," + grade->high + ",\n";
      }
    }
  }
  return text;
}

}  // namespace

std::string figure_title(std::string_view figure) {
  const auto* const title =
      std::find_if(kTitles.begin(), kTitles.end(), [&](const FigureTitle& t) { return t.name == figure; });
  return std::string(title->title) + (title->unit.empty() ? "" : ", " + std::string(title->unit));
}

std::vector<std::string> grade_lines(const GradeReport& report) {
  std::vector<std::string> lines;
  for (const GradedRegion& region : report.surface.regions) {
    const RegionFigures& last = region.times.back();
    std::string line = region.name + ": rusted " + with_interval(*last.figure("rusted_percent")) + " %";
    for (const GradeScale& scale : report.rules.scales) {
      if (has_figure(region, scale.figure))
        line += ", " + scale.title + " " + grade_text(scale, last, least_of(scale, region));
    }
    if (const std::optional<GradedFigure>& d = last.figure("ciede2000")) line += ", CIEDE2000 " + digits(d->value);
    lines.push_back(std::move(line));
  }
  return lines;
}

void write_grade_report(const fs::path& folder, const GradeReport& report) {
  HtmlPage page(report.series.series.name() + ": grades");
  if (const std::optional<HistoryCard> card = read_history_card(report.series.history->folder())) {
    page.paragraph(card->title + (card->about.empty() ? "" : ": " + card->about));
    page.paragraph(credit_text(*card));
  }
  std::vector<std::vector<std::string>> facts;
  for (const SampleFact& fact : report.series.series.facts().sample) facts.push_back({fact.name, fact.text});
  if (!facts.empty()) page.table({"sample", ""}, facts, true);
  for (const std::string& line : grade_lines(report))
    page.paragraph("At " + time_text(report, report.surface.times.back()) + ", " + line + ".");
  if (report.surface.edge_mm > 0.0)
    page.paragraph("A band of " + short_number_text(report.surface.edge_mm) +
                   " mm along the edge of the sample is left out.");
  for (const std::string& note : report.surface.notes) page.paragraph("Note: " + note + ".");
  if (!report.limits.empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const LimitResult& l : report.limits)
      rows.push_back(
          {l.limit.text, l.region, std::string(kLimitStateNames[static_cast<std::size_t>(l.state)]), l.found});
    page.heading("Limits");
    page.table({"limit", "region", "result", "found"}, rows);
  }
  for (const GradedRegion& region : report.surface.regions) {
    page.heading("Region " + region.name);
    page.paragraph(std::to_string(region.num_pixels) + " pixels" +
                   (region.area_mm2 ? ", " + digits(*region.area_mm2) + " mm2" : "") +
                   "; the smallest spot that is counted has " + digits(region.seen_from_percent) + " % of it.");
    add_grade_table(page, report, region);
    add_chart(page, report, region);
    add_times(page, report, region);
    add_forecast_table(page, report, region);
    add_figure_table(page, report, region);
  }
  page.heading("Photographs, and what was counted");
  std::vector<Picture> pictures = pictures_of(report);
  embed_pictures(pictures, folder / kJobWorkFolder / "picture.png");
  std::vector<HtmlPicture> shown;
  for (const Picture& picture : pictures) shown.push_back({picture.source, picture.caption});
  page.pictures(shown);
  add_standards(page, report.rules);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(report.task.command);
  page.link(kGradeReportFile, "The figures as JSON");
  page.link(kGradeTableFile, "The figures as a table");
  page.save(folder / kGradePageFile);
  write_atomically(folder / kGradeTableFile, csv_rows(report));
  save_grade_document(folder, report, grade_lines(report));
}

}  // namespace patinate::analysis
