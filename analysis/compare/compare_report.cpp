#include "analysis/compare/compare_report.h"

#include <nlohmann/json.hpp>

#include "analysis/compare/compare_job.h"
#include "analysis/figures/compared_pair.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/history/warning_json.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

std::string times_text(const HistoryFacts& m) {
  return std::to_string(m.frames.size()) + " frames, " + short_number_text(m.frames.front().time) + " to " +
         short_number_text(m.frames.back().time) + " " + time_unit_text(m.time_unit);
}

Json side_json(const SeriesFile& side) {
  const TextureSeries& series = side.series;
  const HistoryFacts& m = series.facts();
  Json controls = Json::array();
  for (const ControlFacts& c : m.controls)
    controls.push_back({{"name", c.name}, {"range", {c.low, c.high}}, {"unit", c.unit}});
  return Json{{"name", series.name()},
              {"origin", m.origin},
              {"width", series.width()},
              {"height", series.height()},
              {"frames", m.frames.size()},
              {"first_time", m.frames.front().time},
              {"last_time", m.frames.back().time},
              {"time_unit", time_unit_text(m.time_unit)},
              {"texel_size_mm", series.pixel_mm() ? Json(*series.pixel_mm()) : Json(nullptr)},
              {"controls", controls},
              {"warnings", warnings_json(m.warnings)},
              {"key", side.key()}};
}

namespace {

void add_provenance(HtmlPage& page, const SeriesFile& a, const SeriesFile& b) {
  std::vector<std::vector<std::string>> rows{{"name"}, {"origin"}, {"pixels"}, {"times"}, {"texel size (mm)"}, {"key"}};
  for (const SeriesFile* side : {&a, &b}) {
    const TextureSeries& series = side->series;
    const std::optional<double> pixel_mm = series.pixel_mm();
    const std::vector<std::string> cells{series.name(),
                                         series.facts().origin,
                                         size_text(series.width(), series.height()),
                                         times_text(series.facts()),
                                         pixel_mm ? short_number_text(*pixel_mm) : "not known",
                                         side->key()};
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].push_back(cells[i]);
  }
  page.table({"", "A", "B"}, rows);
}

/// What either side's maker warned of: a difference may be that and no aging.
void add_warnings(HtmlPage& page, const SeriesFile& a, const SeriesFile& b) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, side] : {std::pair("A", &a), std::pair("B", &b)}) {
    for (const HistoryWarning& warning : side->series.facts().warnings) rows.push_back({name, warning_text(warning)});
  }
  if (rows.empty()) return;
  page.heading("Warnings of what is compared");
  page.paragraph("Found when the histories were made. A difference below may be one of these and not aging.");
  page.table({"", "warning"}, rows);
}

}  // namespace

void write_compare_report(const fs::path& folder, const CompareProvenance& provenance,
                          std::span<const Section> sections) {
  HtmlPage page(provenance.a.series.name() + " against " + provenance.b.series.name());
  page.paragraph(
      "How alike two surfaces age: A and B, at equal times or shares of their spans. Where a figure has a number for A "
      "split in two, that is what equal surfaces would show: "
      "the squares of a chess board over A, the black against the white ones.");
  add_provenance(page, provenance.a, provenance.b);
  add_warnings(page, provenance.a, provenance.b);
  const std::vector<std::string> warnings =
      pair_warnings(provenance.a.series.facts(), provenance.b.series.facts(), provenance.options);
  for (const std::string& warning : warnings) page.paragraph("Warning: " + warning + ".");
  for (const Section& section : sections) add_section(page, section, folder, "A split in two");
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(provenance.command);
  page.link(kCompareReportFile, "The figures as JSON");
  page.link(kCompareTableFile, "The figures as a table");
  page.save(folder / kComparePageFile);
  write_atomically(folder / kCompareTableFile, figures_csv(sections));
  Json options = Json::object();
  for (const auto& [name, value] : option_values(provenance.options)) options[name] = value;
  options["seed"] = std::to_string(provenance.options.seed);
  save_json(folder / kCompareReportFile, Json{{"format", "patinate.compare"},
                                              {"version", 1},
                                              {"a", side_json(provenance.a)},
                                              {"b", side_json(provenance.b)},
                                              {"figures", listed_figures_json(sections)},
                                              {"undefined_sections", undefined_sections_json(sections)},
                                              {"warnings", warnings},
                                              {"curves", listed_curves_json(sections)},
                                              {"options", options},
                                              {"command", provenance.command},
                                              {"key", provenance.key}});
}

}  // namespace patinate::analysis
