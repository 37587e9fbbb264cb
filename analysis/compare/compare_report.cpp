#include "analysis/compare/compare_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/compare/compare_job.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/image/image_io.h"
#include "libcommon/output/html_page.h"
#include "libcommon/output/svg_chart.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

std::string number(const std::optional<double>& v) { return v ? short_number_text(rounded(*v, 3) + 0.0) : "-"; }

std::string svg_of(const Curve& curve) {
  Chart chart{.title = curve.title, .x_label = curve.x_name, .y_label = curve.y_name, .from_zero = curve.from_zero && !curve.is_logarithmic, .log_x = curve.is_logarithmic, .log_y = curve.is_logarithmic};
  for (const CurveColumn& c : curve.columns) chart.series.push_back({c.name, curve.x, c.values, c.band, c.is_reference});
  return svg_chart(chart);
}

/// What a reader should look at first: value next to what equal would look like.
std::vector<std::string> figure_row(const Figure& f) {
  if (!f.value) return {f.title, "undefined: " + f.undefined, "", f.split ? number(f.split) : "", f.unit};
  const std::string interval = f.low && f.high ? number(f.low) + " to " + number(f.high) : "";
  return {f.title, number(f.value), interval, f.split ? number(f.split) : "", f.unit};
}

void add_section(HtmlPage& page, const Section& section, const Json& json, const fs::path& folder, Json& files) {
  page.heading(section.title);
  if (!section.undefined.empty()) page.paragraph("Undefined: " + section.undefined + ".");
  for (const std::string& text : section.paragraphs) page.paragraph(text);
  if (!section.figures.empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const Figure& f : section.figures) rows.push_back(figure_row(f));
    page.table({"figure", "value", "95 % interval", "A split in two", "unit"}, rows);
  }
  for (std::size_t i = 0; i < section.pictures.size(); ++i) page.picture({json.at("pictures").at(i).at("source").get<std::string>(), section.pictures[i].caption});
  for (const Curve& curve : section.curves) {
    const fs::path file = fs::path("curves") / (curve.name + ".csv");
    write_atomically(folder / file, curve_csv(curve));
    files.push_back({{"file", file.generic_string()}, {"title", curve.title}});
    page.drawing(svg_of(curve));
  }
}

std::string times_text(const Json& side) {
  return std::to_string(side.at("frames").get<int>()) + " frames, " + short_number_text(side.at("first_time").get<double>()) + " to " + short_number_text(side.at("last_time").get<double>()) + " " +
         side.at("time_unit").get<std::string>();
}

Json describe_side(const TextureSeries& series) {
  const HistoryManifest& m = series.manifest();
  Json controls = Json::array();
  for (const ControlParameter& c : m.controls) controls.push_back({{"name", c.name}, {"range", {c.low, c.high}}, {"unit", c.unit}});
  return Json{{"name", series.name()}, {"origin", m.origin}, {"width", series.width()}, {"height", series.height()}, {"frames", m.frames.size()},
          {"first_time", m.frames.front().time}, {"last_time", m.frames.back().time}, {"time_unit", time_unit_text(m.time_unit)},
          {"texel_size_mm", series.pixel_mm() ? Json(*series.pixel_mm()) : Json(nullptr)}, {"controls", controls}, {"key", series.key()}};
}

void add_provenance(HtmlPage& page, const Json& a, const Json& b) {
  const auto text = [](const Json& v) { return v.is_null() ? std::string("not known") : v.is_string() ? v.get<std::string>() : short_number_text(v.get<double>()); };
  const auto size = [](const Json& side) { return size_text(side.at("width").get<int>(), side.at("height").get<int>()); };
  std::vector<std::vector<std::string>> rows{{"name", text(a.at("name")), text(b.at("name"))},
                                             {"origin", text(a.at("origin")), text(b.at("origin"))},
                                             {"pixels", size(a), size(b)},
                                             {"times", times_text(a), times_text(b)},
                                             {"texel size (mm)", text(a.at("texel_size_mm")), text(b.at("texel_size_mm"))},
                                             {"key", text(a.at("key")), text(b.at("key"))}};
  page.table({"", "A", "B"}, rows);
}

}  // namespace

std::string picture_uri(const ImageF& image, const fs::path& scratch) {
  fs::create_directories(scratch.parent_path());
  write_srgb8(scratch, image);
  std::string uri = data_uri(scratch);
  fs::remove(scratch);
  return uri;
}

void write_compare_report(const fs::path& folder, const CompareProvenance& provenance, const std::vector<Json>& sections) {
  fs::create_directories(folder / "curves");
  const Json a = describe_side(provenance.a), b = describe_side(provenance.b);
  HtmlPage page(provenance.a.name() + " against " + provenance.b.name());
  page.paragraph("How alike two surfaces age: A and B, at equal times or shares of their spans. Where a figure has a number for A split in two, that is what equal surfaces would show: "
                 "the squares of a chess board over A, the black against the white ones.");
  add_provenance(page, a, b);
  Json figures = Json::array(), curves = Json::array(), undefined = Json::array();
  for (const Json& json : sections) {
    const Section section = section_from_json(json);
    add_section(page, section, json, folder, curves);
    if (!section.undefined.empty()) undefined.push_back({{"section", section.name}, {"reason", section.undefined}});
    for (const Figure& f : section.figures) {
      Json one = figure_json(f);
      one["section"] = section.name;
      figures.push_back(std::move(one));
    }
  }
  Json options = Json::object();
  for (const auto& [name, value] : option_values(provenance.options)) options[name] = value;
  options["seed"] = std::to_string(provenance.options.seed);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(provenance.command);
  page.link(kCompareReportFile, "The figures as JSON");
  page.save(folder / kComparePageFile);
  save_json(folder / kCompareReportFile, Json{{"format", "patinate.compare"}, {"version", 1}, {"a", a}, {"b", b}, {"figures", figures}, {"undefined_sections", undefined},
                                              {"curves", curves}, {"options", options}, {"command", provenance.command}, {"key", provenance.key}});
}

}  // namespace patinate
