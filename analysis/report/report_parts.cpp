#include "patinate/analysis/report_parts.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/csv.h"
#include "libcommon/core/text.h"
#include "libcommon/document/document.h"
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

void describe(DocumentVisitor& v, Figure& f) {
  const auto optional = [&](std::string_view name, std::string_view help, std::optional<double>& value) {
    v.member(if_set(name, help), value);
  };
  v.member({"name", "snake_case, unique in the report."}, f.name);
  v.member({"title", "For people."}, f.title);
  v.member({"unit"}, f.unit);
  v.member(or_null("value", "null: `undefined` says why."), f.value);
  optional("low", "95 % interval.", f.low);
  optional("high", "", f.high);
  optional("after", "Of a moment: the frames between which it lies; left out where it is a frame's.", f.after);
  optional("before", "", f.before);
  optional("split", "The same figure for A, or the source, against itself split in two.", f.split);
  v.member(if_set("undefined"), f.undefined);
}

void describe(DocumentVisitor& v, CurveColumn& c) {
  v.member({"name"}, c.name);
  v.member({.name = "values", .has_nulls = true}, c.values);
  v.member({"band", "95 % interval."}, c.band);
  v.member({"is_reference"}, c.is_reference);
}

void describe(DocumentVisitor& v, Curve& c) {
  v.member({"name"}, c.name);
  v.member({"title"}, c.title);
  v.member({"x_name"}, c.x_name);
  v.member({"y_name"}, c.y_name);
  v.member({"x"}, c.x);
  v.member({"columns"}, c.columns);
  v.member({"is_logarithmic"}, c.is_logarithmic);
  v.member({"from_zero"}, c.from_zero);
}

void describe(DocumentVisitor& v, Picture& p) {
  v.member({"name"}, p.name);
  v.member({"caption"}, p.caption);
  v.member(if_set("source"), p.source);
}

void describe(DocumentVisitor& v, Section& s) {
  v.member({"name"}, s.name);
  v.member({"title"}, s.title);
  v.member({"paragraphs"}, s.paragraphs);
  v.member({"undefined"}, s.undefined);
  v.member({"figures"}, s.figures);
  v.member({"curves"}, s.curves);
  v.member({"pictures"}, s.pictures);
}

Json figure_json(const Figure& figure) {
  Figure stated = as_stated(figure);
  return object_json(described(stated));
}

Json section_json(const Section& section) {
  Section stated{.name = section.name,
                 .title = section.title,
                 .paragraphs = section.paragraphs,
                 .figures = {},
                 .curves = {},
                 .pictures = {},
                 .undefined = section.undefined};
  for (const Figure& f : section.figures) stated.figures.push_back(as_stated(f));
  for (const Curve& c : section.curves) stated.curves.push_back(as_stated(c));
  for (const Picture& p : section.pictures)
    stated.pictures.push_back({.name = p.name, .caption = p.caption, .image = {}, .source = p.source});
  return object_json(described(stated));
}

Section section_from_json(const Json& json) {
  Section section;
  read_object(json, described(section));
  return section;
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
