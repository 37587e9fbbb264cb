#include "capture/timelapse/light_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/project/photo_facts.h"
#include "capture/stability/first_light.h"
#include "capture/thickness/thickness_warnings.h"
#include "capture/timelapse/ingest_warnings.h"
#include "libcommon/core/median.h"
#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

constexpr std::array<std::string_view, 3> kEvidenceNames{"none", "possible", "clear"};
constexpr double kLamp = 10.0;            ///< Fall-off that few lamps have.
constexpr double kVariedExposure = 1.05;  ///< Nominal values are that exact.
constexpr double kMinChange = 0.01;       ///< Change of a factor, to be named.
constexpr std::size_t kMaxChanged = 3;    ///< Photographs that are named with their factors.

std::string ratio_text(double ratio) { return hundredths(ratio) + " : 1"; }

double size_of(const std::array<double, 3>& factors) {
  double size = 0.0;
  for (double f : factors) size = std::max(size, std::abs(std::log(f)));
  return size;
}

std::array<FactorRange, 3> read_ranges(JsonReader& json) {
  std::array<FactorRange, 3> ranges{};
  const std::vector<JsonReader> channels = json.member("ranges").elements(3);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const std::vector<double> range = channels[c].numbers(2, above(0));
    ranges[c] = {range[0], range[1]};
  }
  return ranges;
}

std::string ranges_text(const std::array<FactorRange, 3>& ranges) {
  const auto one = [](const FactorRange& r) { return hundredths(r[0]) + " to " + hundredths(r[1]); };
  if (one(ranges[0]) == one(ranges[1]) && one(ranges[0]) == one(ranges[2])) return one(ranges[0]);
  return one(ranges[0]) + " (red), " + one(ranges[1]) + " (green), " + one(ranges[2]) + " (blue)";
}

/// Every photograph that was changed, the first few with their factors.
std::string deflicker_text(const DeflickerReport& report) {
  if (report.changed.empty()) return "deflicker: no photograph is changed";
  std::string text = "deflicker: factors " + ranges_text(report.ranges) + "; most changed: ";
  std::vector<std::string> others;
  for (std::size_t k = 0; k < report.changed.size(); ++k) {
    const ChangedPhoto& p = report.changed[k];
    if (k >= kMaxChanged) others.push_back(p.photo);
    if (k >= kMaxChanged) continue;
    text += (k == 0 ? "" : ", ") + p.photo + " (" + hundredths(p.factors[0]) + ", " + hundredths(p.factors[1]) + ", " +
            hundredths(p.factors[2]) + ")";
  }
  if (!others.empty()) text += "; also changed: " + photo_list(others) + " (survey.json has all)";
  return text;
}

/// Places and lengths in half of the photograph's longer side, from its middle.
Json static_light_json(const StaticLight& light) {
  Json json{{"ratio", light.ratio}};
  if (light.lamp) {
    json["lamp"] = {{"below", {light.lamp->below.x, light.lamp->below.y}},
                    {"height", 1.0 / std::sqrt(light.lamp->inverse_height2)}};
  }
  if (light.reflection) {
    json["reflection"] = {{"middle", {light.reflection->middle.x, light.reflection->middle.y}},
                          {"width", 1.0 / std::sqrt(light.reflection->inverse_width2)},
                          {"strength", light.reflection->strength}};
  }
  return json;
}

PicturePoint read_point(JsonReader json) {
  const std::vector<double> numbers = json.numbers(2);
  return {numbers[0], numbers[1]};
}

StaticLight read_static_light(JsonReader json) {
  StaticLight light;
  light.ratio = json.member("ratio").number(at_least(1));
  const auto inverse_square = [](double v) { return 1.0 / (v * v); };
  if (json.has("lamp")) {
    JsonReader lamp = json.member("lamp");
    light.lamp = LampLight{read_point(lamp.member("below")), inverse_square(lamp.member("height").number(above(0)))};
  }
  if (json.has("reflection")) {
    JsonReader r = json.member("reflection");
    light.reflection =
        LampReflection{read_point(r.member("middle")), inverse_square(r.member("width").number(above(0))),
                       r.member("strength").number(at_least(0))};
  }
  return light;
}

std::string static_light_text(const StaticLight& light) {
  std::string text = "removed constant uneven lighting: ";
  if (light.lamp) text += "of a near lamp, " + ratio_text(light.ratio);
  if (light.reflection) {
    text += std::string(light.lamp ? ", and " : "") + "a reflection of up to " +
            hundredths(light.reflection->strength) + " (1 = white)";
  }
  return text + "; keep it with --static-light off";
}

/// Warning about light inside a mask: nothing is said of what lies around it.
HistoryWarning uneven_warning(const UnevenLight& uneven, bool is_divided) {
  HistoryWarning warning{.about = WarningSubject::Light, .text = "", .cure = "", .share = 0.0};
  const std::string ratio =
      ratio_text(uneven.ratio) + (uneven.is_inside_mask ? " inside the mask" : " over the picture");
  if (uneven.evidence == LightEvidence::Clear) {
    warning.text = "the light is uneven, " + ratio + (is_divided ? ", after the flat field" : "") +
                   ", and it stayed so while the surface changed";
  } else {
    warning.text =
        "brightness falls off by " + ratio + (is_divided ? ", after the flat field" : "") +
        "; this may be uneven light or a gradient of the surface itself" +
        (uneven.ratio > kLamp && !uneven.is_inside_mask ? ", or dark surroundings that belong outside a `mask`" : "") +
        "; the photographs cannot tell which";
  }
  warning.cure =
      is_divided ? "--flat-field IMAGE, a photograph of a uniform surface under the same lamp"
      : uneven.evidence == LightEvidence::Clear
          ? "--flat-field estimate divides it out; --flat-field IMAGE, a photograph of a uniform surface, is "
            "surer"
          : "if the light is uneven, use --flat-field estimate, or better --flat-field IMAGE with a photograph of a "
            "uniform surface; if a new, polished surface mirrors its surroundings, use --flat-field first, which "
            "removes the reflection as far as it persists";
  // Where half of the light is missing, half of the color is.
  warning.share = 1.0 - 1.0 / uneven.ratio;
  if (uneven.evidence != LightEvidence::Clear) warning.share *= 0.5;
  return warning;
}

/// Tells that `--flat-field first` divided nothing out.
bool is_even_already(const FlatFieldReport& field) {
  return !field.last_shares.empty() && field.ratio < kEvenFirstLight;
}

std::string last_share_text(const FlatFieldReport& field) {
  if (field.last_shares.empty()) return "";
  const auto& s = field.last_shares;
  return "; the last photograph still showed " + hundredths(s[0]) + ", " + hundredths(s[1]) + ", " + hundredths(s[2]) +
         " of it";
}

std::string flat_field_text(const FlatFieldReport& field, const std::optional<UnevenLight>& uneven) {
  if (is_even_already(field))
    return "flat field: the first photograph is even already (" + ratio_text(field.ratio) + "); nothing is divided out";
  return "flat field: " + ratio_text(field.ratio) + " divided out, factors " + ranges_text(field.ranges) +
         last_share_text(field) + (uneven ? "; " + ratio_text(uneven->ratio) + " is left" : "");
}

}  // namespace

void add_light_report(Json& survey, const SeriesLight& report) {
  if (report.uneven)
    survey["uneven_light"] = {{"ratio", report.uneven->ratio},
                              {"evidence", kEvidenceNames[static_cast<std::size_t>(report.uneven->evidence)]},
                              {"is_inside_mask", report.uneven->is_inside_mask}};
  if (report.flat_field)
    survey["flat_field"] = {{"ratio", report.flat_field->ratio}, {"ranges", report.flat_field->ranges}};
  if (report.flat_field && !report.flat_field->last_shares.empty())
    survey["flat_field"]["last_shares"] = report.flat_field->last_shares;
  if (report.deflicker) {
    Json changed = Json::array();
    for (const ChangedPhoto& p : report.deflicker->changed)
      changed.push_back({{"photo", p.photo}, {"factors", p.factors}});
    survey["deflicker"] = {
        {"ranges", report.deflicker->ranges}, {"changed", changed}, {"unsure", report.deflicker->unsure}};
  }
  if (report.static_light) survey["static_light"] = static_light_json(*report.static_light);
  if (report.layer_window) {
    const LayerWindow& w = *report.layer_window;
    survey["layer_window"] = {{"sigma_px", w.sigma_px}, {"is_chosen", w.is_chosen}};
    if (w.is_chosen) survey["layer_window"].update({{"gap_px", w.gap_px}, {"foretold_to", w.foretold_to}});
  }
  if (report.exif) {
    const ExifExposureReport& e = *report.exif;
    survey["exif_exposure"] = {{"ratio", e.ratio},
                               {"least", {{"photo", e.least_photo}, {"exposure", e.least}}},
                               {"most", {{"photo", e.most_photo}, {"exposure", e.most}}},
                               {"is_white_balance_mixed", e.is_white_balance_mixed}};
  }
}

SeriesLight read_light_report(JsonReader& survey) {
  SeriesLight report;
  if (survey.has("uneven_light")) {
    JsonReader json = survey.member("uneven_light");
    report.uneven = UnevenLight{json.member("ratio").number(at_least(1)),
                                static_cast<LightEvidence>(json.member("evidence").choice(kEvidenceNames))};
    // Histories of earlier versions do not say.
    if (json.has("is_inside_mask")) report.uneven->is_inside_mask = json.member("is_inside_mask").boolean();
  }
  if (survey.has("flat_field")) {
    JsonReader json = survey.member("flat_field");
    report.flat_field = FlatFieldReport{json.member("ratio").number(at_least(1)), read_ranges(json)};
    if (json.has("last_shares")) report.flat_field->last_shares = json.member("last_shares").numbers(3, between(0, 1));
  }
  if (survey.has("deflicker")) {
    JsonReader json = survey.member("deflicker");
    report.deflicker = DeflickerReport{.ranges = read_ranges(json), .changed = {}, .unsure = {}};
    // Histories of earlier versions name the three that were changed most.
    for (JsonReader& entry : json.member(json.has("changed") ? "changed" : "most_changed").elements()) {
      const std::vector<double> factors = entry.member("factors").numbers(3, above(0));
      report.deflicker->changed.push_back({entry.member("photo").string(), {factors[0], factors[1], factors[2]}});
    }
    for (const JsonReader& photo : json.member("unsure").elements()) report.deflicker->unsure.push_back(photo.string());
  }
  if (survey.has("static_light")) report.static_light = read_static_light(survey.member("static_light"));
  if (survey.has("layer_window")) {
    JsonReader json = survey.member("layer_window");
    LayerWindow window{.sigma_px = json.member("sigma_px").number(above(0)),
                       .is_chosen = json.member("is_chosen").boolean()};
    if (window.is_chosen) {
      window.gap_px = static_cast<int>(json.member("gap_px").number(between(1, 10000)));
      window.foretold_to = json.member("foretold_to").number(at_least(0));
    }
    report.layer_window = window;
  }
  if (survey.has("exif_exposure")) {
    JsonReader json = survey.member("exif_exposure");
    JsonReader least = json.member("least"), most = json.member("most");
    report.exif = ExifExposureReport{.ratio = json.member("ratio").number(at_least(1)),
                                     .least_photo = least.member("photo").string(),
                                     .least = least.member("exposure").string(),
                                     .most_photo = most.member("photo").string(),
                                     .most = most.member("exposure").string(),
                                     .is_white_balance_mixed = json.member("is_white_balance_mixed").boolean()};
  }
  return report;
}

std::optional<ExifExposureReport> exif_exposures(const std::vector<CapturePhoto>& photos) {
  using WhiteBalance = ImageExposure::WhiteBalance;
  const CapturePhoto *least = nullptr, *most = nullptr;
  int num_known = 0;
  bool has_auto = false, has_manual = false;
  for (const CapturePhoto& photo : photos) {
    has_auto = has_auto || photo.exposure.white_balance == WhiteBalance::Auto;
    has_manual = has_manual || photo.exposure.white_balance == WhiteBalance::Manual;
    const double amount = photo.exposure.amount();
    if (!(amount > 0.0)) continue;
    ++num_known;
    if (least == nullptr || amount < least->exposure.amount()) least = &photo;
    if (most == nullptr || amount > most->exposure.amount()) most = &photo;
  }
  if (num_known < 2) return std::nullopt;
  return ExifExposureReport{.ratio = most->exposure.amount() / least->exposure.amount(),
                            .least_photo = least->name(),
                            .least = exposure_text(least->exposure),
                            .most_photo = most->name(),
                            .most = exposure_text(most->exposure),
                            .is_white_balance_mixed = has_auto && has_manual};
}

std::vector<std::array<double, 3>> named_factors(std::vector<std::array<double, 3>> factors) {
  for (std::array<double, 3>& f : factors) {
    if (size_of(f) < std::log1p(kMinChange)) f = {1.0, 1.0, 1.0};
  }
  return factors;
}

DeflickerReport deflicker_report(const std::vector<CapturePhoto>& photos,
                                 const std::vector<std::array<double, 3>>& factors, const std::vector<int>& unsure) {
  DeflickerReport report;
  for (std::size_t c = 0; c < 3; ++c) {
    report.ranges[c] = {factors.front()[c], factors.front()[c]};
    for (const auto& f : factors)
      report.ranges[c] = {std::min(report.ranges[c][0], f[c]), std::max(report.ranges[c][1], f[c])};
  }
  std::vector<std::size_t> order(factors.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return size_of(factors[a]) > size_of(factors[b]); });
  for (const std::size_t k : order) {
    if (size_of(factors[k]) > 0.0) report.changed.push_back({photos[k].name(), factors[k]});
  }
  for (int frame : unsure) report.unsure.push_back(photos[frame].name());
  return report;
}

FlatFieldReport flat_field_report(const ImageF& gain) {
  FlatFieldReport report{.ratio = light_ratio(gain)};
  for (int c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (std::int64_t i = 0; i < gain.num_pixels(); ++i) values.push_back(gain.data()[3 * i + c]);
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    report.ranges[c] = {static_cast<double>(*low), static_cast<double>(*high)};
  }
  return report;
}

std::vector<HistoryWarning> light_warnings(const SeriesLight& report, const std::string& flat_field, int num_frames) {
  std::vector<HistoryWarning> warnings;
  if (report.uneven && report.uneven->evidence != LightEvidence::None)
    warnings.push_back(uneven_warning(
        *report.uneven, !flat_field.empty() && !(report.flat_field && is_even_already(*report.flat_field))));
  if (report.deflicker && !report.deflicker->unsure.empty()) {
    const std::vector<std::string>& unsure = report.deflicker->unsure;
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "--deflicker left " + std::to_string(unsure.size()) + " of " +
                                std::to_string(num_frames) + " photographs unchanged relative to the ones before (" +
                                photo_list(unsure) +
                                "): too little of the picture shares one change of light to separate it from aging",
                        .cure = "photograph something that does not age beside it, or fix exposure and white balance",
                        .share = 0.5 * static_cast<double>(unsure.size()) / num_frames,
                        .photos = unsure});
  }
  if (report.exif && report.exif->ratio > kVariedExposure && !report.deflicker) {
    const ExifExposureReport& e = *report.exif;
    warnings.push_back(
        {.about = WarningSubject::Light,
         .text = "the camera's exposure varies " + hundredths(e.ratio) + "-fold by EXIF, from " + e.least_photo + " (" +
                 e.least + ") to " + e.most_photo + " (" + e.most + ")",
         .cure = "--deflicker takes out what of it shows in the photographs; a manual exposure avoids it",
         .share = 0.5 * (1.0 - 1.0 / e.ratio),
         .photos = {e.least_photo, e.most_photo}});
  }
  if (report.exif && report.exif->is_white_balance_mixed && !report.deflicker) {
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "white balance is automatic in some photographs and set by hand in others, by EXIF",
                        .cure = "--deflicker takes out what of it shows in the photographs",
                        .share = 0.1});
  }
  return warnings;
}

std::vector<std::string> light_notes(const SeriesLight& report) {
  std::vector<std::string> notes;
  if (report.flat_field) notes.push_back(flat_field_text(*report.flat_field, report.uneven));
  if (report.static_light) notes.push_back(static_light_text(*report.static_light));
  if (report.deflicker) {
    notes.push_back(deflicker_text(*report.deflicker));
  }
  if (report.layer_window && report.layer_window->is_chosen)
    notes.push_back("thickness: " + layer_window_text(*report.layer_window));
  return notes;
}

}  // namespace patinate::capture
