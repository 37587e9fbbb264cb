#include "capture/timelapse/repair.h"

#include <nlohmann/json.hpp>

#include "patinate/core/json.h"

namespace patinate::capture {

namespace {

constexpr std::array<std::string_view, 2> kHighlightNames{"mask", "keep"};

}  // namespace

void describe(OptionVisitor& v, RepairOptions& o) {
  v.visit({"stabilise", "Lay moved photographs over the first one"}, o.stabilise);
  v.visit({"deflicker", "Take changes of exposure between photographs out; slow brightening and darkening stay"}, o.deflicker);
  v.visit({"flat_field", "Divide by the lamp's fall-off: IMAGE of a uniform surface, or `estimate`"}, o.flat_field);
  v.visit_choice({"highlights", "What becomes of saturated pixels and the flash's highlight"}, o.highlights, kHighlightNames);
  describe(v, o.survey);
  describe(v, o.deflicker_options);
  describe(v, o.flat_field_options);
  describe(v, o.highlight_options);
  describe(v, o.fill);
}

SurveyReport read_survey_report(const std::filesystem::path& history) {
  SurveyReport report;
  const std::filesystem::path file = history / kSurveyFile;
  if (!std::filesystem::exists(file)) return report;
  const Json json = load_json(file);
  JsonReader reader(file.string(), json);
  reader.expect_format("patinate.survey", 1);
  report.is_stabilised = reader.member("stabilised").boolean();
  report.is_deflickered = reader.member("deflickered").boolean();
  if (reader.has("masked_share")) report.masked_share = reader.member("masked_share").number(between(0, 1));
  if (reader.has("outside_share")) report.outside_share = reader.member("outside_share").number(between(0, 1));
  for (JsonReader& finding : reader.member("findings").elements()) {
    report.findings.push_back({finding.member("photo").string(), finding.member("time").number(), finding.member("is_shifted").boolean(),
                               finding.member("problem").string()});
  }
  return report;
}

}  // namespace patinate::capture
