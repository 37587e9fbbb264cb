#include "capture/timelapse/repair.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "patinate/core/json.h"

namespace patinate::capture {

namespace {

constexpr std::array<std::string_view, 2> kHighlightNames{"mask", "keep"};
constexpr std::array<std::string_view, 2> kStaticLightNames{"auto", "off"};

SurveyPhoto read_photo_name(JsonReader& json) {
  SurveyPhoto photo{.name = json.member("photo").string(), .time = json.member("time").number()};
  if (json.has("number")) photo.number = static_cast<int>(json.member("number").integer(between(0, 1e9)));
  return photo;
}

SurveyFinding read_finding(JsonReader& json) {
  SurveyFinding finding{.photo = read_photo_name(json), .against = "", .problem = json.member("problem").string()};
  if (json.has("against")) finding.against = json.member("against").string();
  const auto problem = [&](const char* kind, double size) -> SurveyProblem {
    // Files of versions before this member say everything in one text.
    if (!json.has("problems")) return {finding.problem, size};
    JsonReader problems = json.member("problems");
    return problems.has(kind) ? SurveyProblem{problems.member(kind).string(), size} : SurveyProblem{};
  };
  if (json.member("is_shifted").boolean()) {
    const std::vector<double> shift = json.member("shift_px").numbers(2);
    finding.moved = problem("moved", std::hypot(shift[0], shift[1]));
  }
  if (json.has("gain")) {
    double size = 0.0;
    for (double gain : json.member("gain").numbers(3, above(0))) size = std::max(size, std::abs(std::log(gain)));
    finding.exposed = problem("exposed", size);
  }
  if (json.has("unclear_gain")) {
    double size = 0.0;
    for (double gain : json.member("unclear_gain").numbers(3, above(0)))
      size = std::max(size, std::abs(std::log(gain)));
    if (!json.has("change_factor")) finding.unclear = problem("unclear", size);
  }
  if (json.has("problems") && json.member("problems").has("unmatched")) {
    finding.jump = problem("unmatched", kUnmatchedSize);
  } else if (json.has("change_factor")) {
    finding.jump = problem("jump", json.member("change_factor").number());
  }
  return finding;
}

}  // namespace

void describe(OptionVisitor& v, RepairOptions& o) {
  v.visit({"stabilize", "Lay moved photographs over the first one"}, o.stabilize);
  v.visit({"deflicker", "Remove changes of exposure between photographs; keep slow brightening and darkening"},
          o.deflicker);
  v.visit({"flat_field",
           "Divide out uneven light: IMAGE shows a uniform surface in the same light; `estimate` uses all photographs; "
           "`first` uses the first one, if it shows a new, uniform surface"},
          o.flat_field);
  v.visit_choice({"highlights", "Saturated pixels and the flash's highlight: mask or keep them"}, o.highlights,
                 kHighlightNames);
  v.visit_choice({"static_light",
                  "Constant light and reflection of a near lamp: auto removes it where the series shows it clearly"},
                 o.static_light, kStaticLightNames);
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
  if (reader.has("unlinked")) {
    for (JsonReader& entry : reader.member("unlinked").elements()) {
      report.unlinked.push_back({.photo = read_photo_name(entry)});
      if (entry.has("similarity")) report.unlinked.back().similarity = entry.member("similarity").number();
      if (entry.has("is_plain")) report.unlinked.back().is_plain = entry.member("is_plain").boolean();
    }
  }
  if (reader.has("restless_light")) {
    JsonReader light = reader.member("restless_light");
    report.restless_light =
        RestlessLight{static_cast<int>(light.member("channel").choice(kChannelNames)),
                      light.member("deviation").number(above(0)), light.member("hidden").number(at_least(1))};
  }
  if (reader.has("better_order")) {
    JsonReader order = reader.member("better_order");
    report.detour = order.member("detour").number();
    for (JsonReader& entry : order.member("photos").elements()) report.better_order.push_back(read_photo_name(entry));
  }
  if (reader.has("excluded")) {
    for (const JsonReader& number : reader.member("excluded").elements())
      report.excluded.push_back(static_cast<int>(number.integer(between(0, 1e9))));
  }
  return report;
}

}  // namespace patinate::capture
