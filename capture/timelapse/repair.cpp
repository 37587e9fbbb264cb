#include "capture/timelapse/repair.h"

#include <nlohmann/json.hpp>

#include "patinate/core/json.h"

namespace patinate::capture {

namespace {

constexpr std::array<std::string_view, 2> kHighlightNames{"mask", "keep"};

}  // namespace

void describe(OptionVisitor& v, RepairOptions& o) {
  v.visit({"stabilize", "Lay moved photographs over the first one"}, o.stabilize);
  v.visit({"deflicker", "Take changes of exposure between photographs out; slow brightening and darkening stay"},
          o.deflicker);
  v.visit({"flat_field", "Divide by the lamp's fall-off: IMAGE of a uniform surface, or `estimate`"}, o.flat_field);
  v.visit_choice({"highlights", "What becomes of saturated pixels and the flash's highlight"}, o.highlights,
                 kHighlightNames);
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
  Json json = load_json(file);
  update_spelling(json, 1, {{"stabilised", "stabilized"}, {"stabilise_residual_px", "stabilize_residual_px"}});
  JsonReader reader(file.string(), json);
  reader.expect_format("patinate.survey", 2);
  report.is_stabilized = reader.member("stabilized").boolean();
  report.is_deflickered = reader.member("deflickered").boolean();
  if (reader.has("masked_share")) report.masked_share = reader.member("masked_share").number(between(0, 1));
  if (reader.has("outside_share")) report.outside_share = reader.member("outside_share").number(between(0, 1));
  for (JsonReader& finding : reader.member("findings").elements()) {
    report.findings.push_back({finding.member("photo").string(), finding.member("time").number(),
                               finding.member("is_shifted").boolean(), finding.member("problem").string()});
  }
  return report;
}

}  // namespace patinate::capture
