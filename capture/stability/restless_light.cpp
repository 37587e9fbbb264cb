#include "capture/stability/restless_light.h"

#include <cmath>
#include <numbers>

#include "libcommon/core/median.h"

namespace patinate::capture {

namespace {

/// The step of cameras (docs/algorithms/stability.md).
constexpr double kThirdOfStop = std::numbers::ln2 / 3.0;
constexpr double kOfDifferences = 2.449489742783178;  ///< sqrt(6): deviation of l(i + 1) - 2 l(i) + l(i - 1) over l's.

double median_deviation(const std::vector<double>& values) {
  const double middle = median(values);
  std::vector<double> deviations;
  for (const double v : values) deviations.push_back(std::abs(v - middle));
  return median(std::move(deviations));
}

/// Unsteadiness of independent factors of the photographs, in logarithms. @param gains  Of neighboring pairs.
double unsteadiness(const std::vector<double>& gains) {
  std::vector<double> differences;
  for (std::size_t i = 1; i < gains.size(); ++i) differences.push_back(std::abs(gains[i] - gains[i - 1]));
  return kSigmaOfMad / kOfDifferences * median(std::move(differences));
}

}  // namespace

std::optional<RestlessLight> find_restless_light(const std::vector<FramePair>& neighbors,
                                                 const SurveyOptions& options) {
  if (neighbors.size() <= kFewPairs) return std::nullopt;
  std::optional<RestlessLight> worst;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> gains;
    for (const FramePair& pair : neighbors) gains.push_back(brightening(pair)[c]);
    const double deviation = unsteadiness(gains), hidden = kOutstanding * median_deviation(gains);
    if (deviation < std::log1p(options.exposure_threshold) || hidden < kThirdOfStop) continue;
    if (worst && std::log(worst->hidden) >= hidden) continue;
    worst = RestlessLight{static_cast<int>(c), std::expm1(deviation), std::exp(hidden)};
  }
  return worst;
}

}  // namespace patinate::capture
