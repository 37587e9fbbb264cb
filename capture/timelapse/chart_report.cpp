#include "capture/timelapse/chart_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/timelapse/ingest_warnings.h"
#include "capture/timelapse/repair.h"
#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

constexpr double kMuch = 3.0;  ///< Mean CIEDE2000 that anybody sees, side by side.
constexpr double kFallsOff =
    0.25;  ///< Change of light over half a diagonal; uneven light is warned of from 1.25 : 1 on.

std::string range_text(std::vector<ChartDrift> drift, double ChartDrift::*figure) {
  const auto is_less = [figure](const ChartDrift& a, const ChartDrift& b) { return a.*figure < b.*figure; };
  const auto [low, high] = std::minmax_element(drift.begin(), drift.end(), is_less);
  return hundredths((*low).*figure) + " to " + hundredths((*high).*figure);
}

/// Fit of the photographs whose chart is used.
struct Fitting {
  double mean = 0.0, worst = 0.0, count = 0.0;
  std::string patch, photo;
};

Fitting fitting(const Json& chart) {
  Fitting all;
  for (const Json& photo : chart.at("photos")) {
    if (!photo.contains("mean_ciede2000")) continue;
    all.mean += photo.at("mean_ciede2000").get<double>();
    all.count += 1.0;
    const double worst = photo.at("worst_ciede2000").get<double>();
    if (worst <= all.worst) continue;
    all.worst = worst;
    all.patch = photo.at("worst_patch").get<std::string>();
    all.photo = photo.at("photo").get<std::string>();
  }
  all.mean /= std::max(1.0, all.count);
  return all;
}

}  // namespace

Json read_chart(const std::filesystem::path& history) {
  const std::filesystem::path file = history / kSurveyFile;
  if (!std::filesystem::exists(file)) return nullptr;
  return load_json(file).value("chart", Json());
}

std::vector<ChartDrift> chart_drift(const Json& chart) {
  std::vector<ChartDrift> drift;
  if (chart.is_null()) return drift;
  std::array<double, 3> first{};
  for (const Json& photo : chart.at("photos")) {
    const auto gain = photo.at("light").at("gain").get<std::array<double, 3>>();
    if (drift.empty()) first = gain;
    std::array<double, 3> light{};  // More light in the codes takes a smaller gain.
    for (std::size_t c = 0; c < 3; ++c) light[c] = first[c] / gain[c];
    drift.push_back({.number = photo.at("number").get<int>(),
                     .exposure = std::cbrt(light[0] * light[1] * light[2]),
                     .red = light[0] / light[1],
                     .blue = light[2] / light[1]});
  }
  return drift;
}

std::vector<std::string> chart_notes(const Json& chart) {
  if (chart.is_null()) return {};
  const Fitting fit = fitting(chart);
  std::vector<std::string> notes{"chart: colors of its patches fit by CIEDE2000 " + hundredths(fit.mean) +
                                 " on average, the worst by " + hundredths(fit.worst) + " (" + fit.patch + " in " +
                                 fit.photo + ")"};
  const std::vector<ChartDrift> drift = chart_drift(chart);
  if (drift.size() > 1)
    notes.push_back("chart: against the first photograph, exposure " + range_text(drift, &ChartDrift::exposure) +
                    ", red over green " + range_text(drift, &ChartDrift::red) + ", blue over green " +
                    range_text(drift, &ChartDrift::blue) + "; taken out");
  const Json& vignetting = chart.at("camera").at("vignetting");
  if (!vignetting.is_null())
    notes.push_back("chart: vignetting of " + fixed_percent_text(1.0 - std::exp(-vignetting.get<double>())) +
                    " in the corners, taken out");
  return notes;
}

std::vector<HistoryWarning> chart_warnings(const Json& chart) {
  std::vector<HistoryWarning> warnings;
  if (chart.is_null()) return warnings;
  std::vector<std::string> interpolated;
  std::string first_problem, steepest_photo;
  double steepest = 0.0;
  for (const Json& photo : chart.at("photos")) {
    const std::string name = photo.at("photo").get<std::string>();
    const auto slope = photo.at("light").at("slope").get<std::array<double, 2>>();
    if (std::hypot(slope[0], slope[1]) > steepest) steepest = std::hypot(slope[0], slope[1]), steepest_photo = name;
    if (!photo.contains("problem")) continue;
    if (interpolated.empty()) first_problem = photo.at("problem").get<std::string>();
    interpolated.push_back(name);
  }
  const double count = static_cast<double>(chart.at("photos").size());
  if (!interpolated.empty())
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "the light of " + std::to_string(interpolated.size()) + " of " +
                                std::to_string(chart.at("photos").size()) + " photographs (" +
                                photo_list(interpolated) + ") is interpolated: " + interpolated.front() + " " +
                                first_problem,
                        .cure = "leave them out (`exclude`) if they may have been taken in another light",
                        .share = static_cast<double>(interpolated.size()) / count,
                        .photos = interpolated});
  const Fitting fit = fitting(chart);
  if (fit.mean > kMuch)
    warnings.push_back(
        {.about = WarningSubject::Light,
         .text = "colors of the `chart` fit by CIEDE2000 " + hundredths(fit.mean) + " on average, the worst by " +
                 hundredths(fit.worst) + " (" + fit.patch + " in " + fit.photo +
                 "): so far are colors from what is stated",
         .cure = "camera RAW, a lamp with a full spectrum, even light over the chart, or a `table` of it",
         .share = 0.5});
  if (steepest > kFallsOff)
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "light changes by " + fixed_percent_text(std::expm1(steepest), 0) +
                                " from the middle of the picture to a corner, as the `chart` in " + steepest_photo +
                                " shows; this is not divided out",
                        .cure = "--flat-field IMAGE, a photograph of a uniform surface; or light from two sides",
                        .share = std::min(1.0, steepest)});
  return warnings;
}

}  // namespace patinate::capture
