#include "patinate/analysis/report_parts.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/csv.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr int kDigits = 9;

double stated(double v, const std::string& of) {
  if (!std::isfinite(v)) throw InvalidInput("report: " + of + " is not finite");
  return rounded(v, kDigits) + 0.0;  // no -0
}

std::optional<double> stated(const std::optional<double>& v, const std::string& of) {
  return v ? std::optional(stated(*v, of)) : std::nullopt;
}

std::optional<double> number_of(const Json& json) {
  return json.is_number() ? std::optional(json.get<double>()) : std::nullopt;
}

}  // namespace

Figure as_stated(Figure f) {
  for (std::optional<double>* v : {&f.value, &f.low, &f.high, &f.after, &f.before, &f.split}) *v = stated(*v, f.name);
  if (f.value)
    f.undefined.clear();
  else if (f.undefined.empty())
    f.undefined = "not defined for this input";
  return f;
}

Curve as_stated(Curve curve) {
  for (CurveColumn& column : curve.columns) {
    for (std::optional<double>& v : column.values) v = stated(v, curve.name);
    for (auto& [low, high] : column.band) low = stated(low, curve.name), high = stated(high, curve.name);
  }
  return curve;
}

Json figure_json(const Figure& figure) {
  const Figure f = as_stated(figure);
  Json json{{"name", f.name}, {"title", f.title}, {"unit", f.unit}, {"value", optional_json(f.value)}};
  if (f.low) json["low"] = *f.low;
  if (f.high) json["high"] = *f.high;
  if (f.after) json["after"] = *f.after;
  if (f.before) json["before"] = *f.before;
  if (f.split) json["split"] = *f.split;
  if (!f.value) json["undefined"] = f.undefined;
  return json;
}

Figure figure_from_json(const Json& json) {
  Figure figure{.name = json.at("name"),
                .title = json.at("title"),
                .unit = json.at("unit"),
                .value = number_of(json.at("value"))};
  if (json.contains("low")) figure.low = number_of(json.at("low"));
  if (json.contains("high")) figure.high = number_of(json.at("high"));
  if (json.contains("after")) figure.after = number_of(json.at("after"));
  if (json.contains("before")) figure.before = number_of(json.at("before"));
  if (json.contains("split")) figure.split = number_of(json.at("split"));
  if (json.contains("undefined")) figure.undefined = json.at("undefined");
  return figure;
}

Json picture_json(const Picture& picture) {
  Json json{{"name", picture.name}, {"caption", picture.caption}};
  if (!picture.source.empty()) json["source"] = picture.source;
  return json;
}

Picture picture_from_json(const Json& json) {
  Picture picture{.name = json.at("name"), .caption = json.at("caption")};
  if (json.contains("source")) picture.source = json.at("source");
  return picture;
}

Json section_json(const Section& section) {
  Json json{{"name", section.name},
            {"title", section.title},
            {"paragraphs", section.paragraphs},
            {"undefined", section.undefined}};
  json["figures"] = Json::array();
  for (const Figure& f : section.figures) json["figures"].push_back(figure_json(f));
  json["curves"] = Json::array();
  for (const Curve& curve : section.curves) {
    const Curve c = as_stated(curve);
    Json columns = Json::array();
    for (const CurveColumn& column : c.columns) {
      Json values = Json::array(), band = Json::array();
      for (const auto& v : column.values) values.push_back(optional_json(v));
      for (const auto& [low, high] : column.band) band.push_back(Json{low, high});
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
  for (const Picture& p : section.pictures) json["pictures"].push_back(picture_json(p));
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
  for (const Json& f : json.at("figures")) s.figures.push_back(figure_from_json(f));
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
  for (const Json& p : json.at("pictures")) s.pictures.push_back(picture_from_json(p));
  return s;
}

std::string figures_csv(std::span<const Section> sections) {
  std::string text = "section,figure,unit,value,low (95 %),high (95 %),A split in two,undefined,after,before\n";
  for (const Section& section : sections) {
    for (const Figure& given : section.figures) {
      const Figure f = as_stated(given);
      text += csv_cell(section.name) + "," + csv_cell(f.name) + "," + csv_cell(f.unit) + "," + csv_cell(f.value) + "," +
              csv_cell(f.low) + "," + csv_cell(f.high) + "," + csv_cell(f.split) + "," + csv_cell(f.undefined) + "," +
              csv_cell(f.after) + "," + csv_cell(f.before) + "\n";
    }
  }
  return text;
}

std::string curve_csv(const Curve& curve) {
  std::string text = csv_cell(curve.x_name);
  for (const CurveColumn& c : curve.columns) {
    for (const char* end : {"", " low", " high"}) {
      if (*end != '\0' && c.band.empty()) continue;
      text += "," + csv_cell(c.name + end + (curve.y_name.empty() ? "" : " [" + curve.y_name + "]"));
    }
  }
  text += "\n";
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    text += csv_cell(std::optional(curve.x[i]));
    for (const CurveColumn& c : curve.columns) {
      text += "," + csv_cell(c.values[i]);
      if (!c.band.empty())
        text += "," + csv_cell(std::optional(c.band[i].first)) + "," + csv_cell(std::optional(c.band[i].second));
    }
    text += "\n";
  }
  return text;
}

}  // namespace patinate::analysis
