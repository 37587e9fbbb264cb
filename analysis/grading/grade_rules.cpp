#include "analysis/grading/grade_rules.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/grading/graded_figure.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

extern const std::string_view kGrades;  ///< grades.json

namespace {

RustRule read_rust(JsonReader json) {
  RustRule rust;
  const std::vector<double> hue = json.member("hue_deg").numbers(2, between(-180, 180));
  if (!(hue[0] < hue[1])) json.member("hue_deg").fail("two angles, the lower one first");
  rust.low_hue_deg = hue[0];
  rust.high_hue_deg = hue[1];
  rust.least_chroma = json.member("least_chroma").number(at_least(0));
  if (json.has("least_lightness")) rust.least_lightness = json.member("least_lightness").number(between(0, 100));
  rust.most_lightness = json.member("most_lightness").number(between(rust.least_lightness, 100));
  rust.least_change = json.member("least_change").number(above(0));
  rust.least_area_px = json.member("least_area_px").number(at_least(1));
  rust.pinpoint_mm = json.member("pinpoint_mm").number(above(0));
  if (json.has("about")) (void)json.member("about").string();
  json.finish();
  return rust;
}

Grade read_grade(const JsonReader& json) {
  const std::vector<JsonReader> parts = json.elements(3);
  if (parts.size() < 2) json.fail("a grade, its largest value, and a word if it has one");
  Grade grade{parts[0].string(), parts[1].number(at_least(0)), parts.size() > 2 ? parts[2].string() : ""};
  const std::optional<double> number = parse_number(grade.name);
  if (!number || *number != std::floor(*number)) parts[0].fail("a whole number as text");
  return grade;
}

GradeScale read_scale(JsonReader json) {
  GradeScale scale;
  scale.name = json.member("name").string();
  scale.title = json.member("title").string();
  scale.figure = kGradedFigureNames[static_cast<std::size_t>(json.member("figure").choice(kGradedFigureNames))];
  scale.standard = json.member("standard").string();
  scale.edition = json.member("edition").string();
  scale.clause = json.member("clause").string();
  scale.is_checked = json.member("checked").boolean();
  scale.note = json.member("note").string();
  for (const JsonReader& grade : json.member("grades").elements(100)) {
    scale.grades.push_back(read_grade(grade));
    if (scale.grades.size() > 1 && !(scale.grades.end()[-2].up_to < scale.grades.back().up_to))
      grade.fail("a larger value than that of the grade before");
  }
  if (scale.grades.size() < 2) json.member("grades").fail("two grades or more");
  json.finish();
  return scale;
}

GradeRules read_rules(JsonReader json) {
  json.expect_format("patinate.grades", 1);
  GradeRules rules{read_rust(json.member("rust")), {}};
  for (const JsonReader& element : json.member("scales").elements(100)) {
    GradeScale scale = read_scale(element);
    for (const GradeScale& other : rules.scales) {
      if (other.name == scale.name) element.fail("a name that no other scale has");
    }
    rules.scales.push_back(std::move(scale));
  }
  json.finish();
  return rules;
}

}  // namespace

std::size_t grade_index(const GradeScale& scale, double value) {
  const auto found =
      std::find_if(scale.grades.begin(), scale.grades.end(), [value](const Grade& g) { return value <= g.up_to; });
  return std::min(static_cast<std::size_t>(found - scale.grades.begin()), scale.grades.size() - 1);
}

GradeRules standard_grade_rules() {
  const Json json = Json::parse(kGrades);
  return read_rules(JsonReader("grades.json", json));
}

GradeRules read_grade_rules(const std::filesystem::path& file) {
  const Json json = load_json(file);
  return read_rules(JsonReader(file.string(), json));
}

}  // namespace patinate::analysis
