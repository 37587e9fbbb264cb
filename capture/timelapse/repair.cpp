#include "capture/timelapse/repair.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "patinate/core/json.h"

namespace patinate::capture {

namespace {

constexpr std::array<std::string_view, 2> kHighlightNames{"mask", "keep"};

SurveyFinding read_finding(JsonReader& json) {
  SurveyFinding finding{.photo = json.member("photo").string(),
                        .time = json.member("time").number(),
                        .is_shifted = json.member("is_shifted").boolean(),
                        .problem = json.member("problem").string()};
  if (finding.is_shifted) {
    const std::vector<double> shift = json.member("shift_px").numbers(2);
    finding.size = std::hypot(shift[0], shift[1]);
  }
  if (json.has("gain")) {
    finding.is_exposure_changed = true;
    for (double gain : json.member("gain").numbers(3, above(0)))
      finding.size = std::max(finding.size, std::abs(std::log(gain)));
  }
  if (json.has("unclear_gain")) {
    finding.is_light_unclear = true;
    for (double gain : json.member("unclear_gain").numbers(3, above(0)))
      finding.size = std::max(finding.size, std::abs(std::log(gain)));
  }
  if (json.has("change_factor")) {
    finding.is_jump = true;
    finding.size = std::max(finding.size, json.member("change_factor").number());
  }
  return finding;
}

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
  report.light = read_light_report(reader);
  for (JsonReader& finding : reader.member("findings").elements()) {
    report.findings.push_back(read_finding(finding));
  }
  return report;
}

}  // namespace patinate::capture
