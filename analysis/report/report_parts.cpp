#include "patinate/analysis/report_parts.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr int kDigits = 9;

Json number_json(const std::optional<double>& v, const std::string& of) {
  if (!v) return nullptr;
  if (!std::isfinite(*v)) throw InvalidInput("report: " + of + " is not finite");
  return rounded(*v, kDigits) + 0.0;
}

std::optional<double> number_of(const Json& json) {
  return json.is_number() ? std::optional(json.get<double>()) : std::nullopt;
}

/// For CSV: commas in a name would make columns.
std::string cell(std::string text) {
  for (char& c : text) c = c == ',' || c == '\n' || c == '"' ? ' ' : c;
  return text;
}

std::string cell(const std::optional<double>& v) { return v ? number_text(rounded(*v, kDigits) + 0.0) : ""; }

}  // namespace

Json figure_json(const Figure& f) {
  Json json{{"name", f.name}, {"title", f.title}, {"unit", f.unit}, {"value", number_json(f.value, f.name)}};
  if (f.low) json["low"] = number_json(f.low, f.name);
  if (f.high) json["high"] = number_json(f.high, f.name);
  if (f.split) json["split"] = number_json(f.split, f.name);
  if (!f.value) json["undefined"] = f.undefined.empty() ? "not defined for this input" : f.undefined;
  return json;
}

Json section_json(const Section& section) {
  Json json{{"name", section.name},
            {"title", section.title},
            {"paragraphs", section.paragraphs},
            {"undefined", section.undefined}};
  json["figures"] = Json::array();
  for (const Figure& f : section.figures) json["figures"].push_back(figure_json(f));
  json["curves"] = Json::array();
  for (const Curve& c : section.curves) {
    Json columns = Json::array();
    for (const CurveColumn& column : c.columns) {
      Json values = Json::array(), band = Json::array();
      for (const auto& v : column.values) values.push_back(number_json(v, c.name));
      for (const auto& [low, high] : column.band)
        band.push_back(Json{number_json(low, c.name), number_json(high, c.name)});
      columns.push_back(
          {{"name", column.name}, {"values", values}, {"band", band}, {"is_reference", column.is_reference}});
    }
    json["curves"].push_back({{"name", c.name},
                              {"title", c.title},
                              {"x_name", c.x_name},
                              {"y_name", c.y_name},
                              {"x", c.x},
                              {"columns", columns},
                              {"is_logarithmic", c.is_logarithmic},
                              {"from_zero", c.from_zero}});
  }
  json["pictures"] = Json::array();
  for (const Picture& p : section.pictures) json["pictures"].push_back({{"name", p.name}, {"caption", p.caption}});
  return json;
}

Section section_from_json(const Json& json) {
  Section s{.name = json.at("name"),
            .title = json.at("title"),
            .paragraphs = json.at("paragraphs"),
            .figures = {},
            .curves = {},
            .pictures = {},
            .undefined = json.at("undefined")};
  for (const Json& f : json.at("figures")) {
    Figure figure{
        .name = f.at("name"), .title = f.at("title"), .unit = f.at("unit"), .value = number_of(f.at("value"))};
    if (f.contains("low")) figure.low = number_of(f.at("low"));
    if (f.contains("high")) figure.high = number_of(f.at("high"));
    if (f.contains("split")) figure.split = number_of(f.at("split"));
    if (f.contains("undefined")) figure.undefined = f.at("undefined");
    s.figures.push_back(std::move(figure));
  }
  for (const Json& c : json.at("curves")) {
    Curve curve{.name = c.at("name"),
                .title = c.at("title"),
                .x_name = c.at("x_name"),
                .y_name = c.at("y_name"),
                .x = c.at("x"),
                .columns = {},
                .is_logarithmic = c.at("is_logarithmic"),
                .from_zero = c.at("from_zero")};
    for (const Json& column : c.at("columns")) {
      CurveColumn out{.name = column.at("name"), .values = {}, .band = {}, .is_reference = column.at("is_reference")};
      for (const Json& v : column.at("values")) out.values.push_back(number_of(v));
      for (const Json& b : column.at("band")) out.band.emplace_back(b.at(0).get<double>(), b.at(1).get<double>());
      curve.columns.push_back(std::move(out));
    }
    s.curves.push_back(std::move(curve));
  }
  for (const Json& p : json.at("pictures")) s.pictures.push_back({p.at("name"), p.at("caption"), {}});
  return s;
}

std::string curve_csv(const Curve& curve) {
  std::string text = cell(curve.x_name);
  for (const CurveColumn& c : curve.columns) {
    text += "," + cell(c.name);
    if (!c.band.empty()) text += "," + cell(c.name) + " low," + cell(c.name) + " high";
  }
  text += "\n";
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    text += cell(std::optional(curve.x[i]));
    for (const CurveColumn& c : curve.columns) {
      text += "," + cell(c.values[i]);
      if (!c.band.empty())
        text += "," + cell(std::optional(c.band[i].first)) + "," + cell(std::optional(c.band[i].second));
    }
    text += "\n";
  }
  return text;
}

}  // namespace patinate::analysis
