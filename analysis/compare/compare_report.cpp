#include "analysis/compare/compare_report.h"

#include <nlohmann/json.hpp>

#include "analysis/compare/compare_job.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

std::string times_text(const Json& side) {
  return std::to_string(side.at("frames").get<int>()) + " frames, " +
         short_number_text(side.at("first_time").get<double>()) + " to " +
         short_number_text(side.at("last_time").get<double>()) + " " + side.at("time_unit").get<std::string>();
}

Json describe_side(const SeriesFile& side) {
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
              {"key", side.key()}};
}

void add_provenance(HtmlPage& page, const Json& a, const Json& b) {
  const auto text = [](const Json& v) {
    return v.is_null()     ? std::string("not known")
           : v.is_string() ? v.get<std::string>()
                           : short_number_text(v.get<double>());
  };
  const auto size = [](const Json& side) {
    return size_text(side.at("width").get<int>(), side.at("height").get<int>());
  };
  std::vector<std::vector<std::string>> rows{
      {"name", text(a.at("name")), text(b.at("name"))},
      {"origin", text(a.at("origin")), text(b.at("origin"))},
      {"pixels", size(a), size(b)},
      {"times", times_text(a), times_text(b)},
      {"texel size (mm)", text(a.at("texel_size_mm")), text(b.at("texel_size_mm"))},
      {"key", text(a.at("key")), text(b.at("key"))}};
  page.table({"", "A", "B"}, rows);
}

}  // namespace

void write_compare_report(const fs::path& folder, const CompareProvenance& provenance,
                          const std::vector<Json>& sections) {
  const Json a = describe_side(provenance.a), b = describe_side(provenance.b);
  HtmlPage page(provenance.a.series.name() + " against " + provenance.b.series.name());
  page.paragraph(
      "How alike two surfaces age: A and B, at equal times or shares of their spans. Where a figure has a number for A "
      "split in two, that is what equal surfaces would show: "
      "the squares of a chess board over A, the black against the white ones.");
  add_provenance(page, a, b);
  Json options = Json::object();
  for (const auto& [name, value] : option_values(provenance.options)) options[name] = value;
  options["seed"] = std::to_string(provenance.options.seed);
  Json report{{"format", "patinate.compare"},
              {"version", 1},
              {"a", a},
              {"b", b},
              {"figures", Json::array()},
              {"undefined_sections", Json::array()},
              {"curves", Json::array()},
              {"options", options},
              {"command", provenance.command},
              {"key", provenance.key}};
  for (const Json& json : sections) add_section(page, json, folder, "A split in two", report);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(provenance.command);
  page.link(kCompareReportFile, "The figures as JSON");
  page.save(folder / kComparePageFile);
  save_json(folder / kCompareReportFile, report);
}

}  // namespace patinate::analysis
