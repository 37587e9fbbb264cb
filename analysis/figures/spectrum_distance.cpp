#include "analysis/figures/spectrum_distance.h"

#include <algorithm>
#include <cmath>

namespace patinate::analysis {

namespace {

constexpr double kFaint = 1e-6;  ///< L*^2: keeps the logarithm of nothing finite; far below what a photograph resolves.

}  // namespace

std::optional<double> log_power(const Spectrum& spectrum, double frequency) {
  const std::vector<double>& power = spectrum.power;
  if (power.empty()) return std::nullopt;
  double at = 2.0 * std::log2(frequency / spectrum.frequencies.front());
  if (std::abs(at - std::round(at)) < 1e-9) at = std::round(at);  // The same ring: nothing to blend.
  if (at < 0.0 || at > static_cast<double>(power.size() - 1)) return std::nullopt;
  const auto k = std::min(static_cast<std::size_t>(at), power.size() - 1), next = std::min(k + 1, power.size() - 1);
  const double f = at - static_cast<double>(k);
  return (1.0 - f) * std::log2(power[k] + kFaint) + f * std::log2(power[next] + kFaint);
}

std::optional<double> octaves_between(const Spectrum& a, double pixel_a, const Spectrum& b, double pixel_b,
                                      int least_rings) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t k = 0; k < a.power.size(); ++k) {
    const std::optional<double> other = log_power(b, a.frequencies[k] / pixel_a * pixel_b);
    if (!other) continue;
    // Power of a spectrum per area: a pixel of another size spreads the same variance over other frequencies.
    sum += std::abs(std::log2(a.power[k] + kFaint) + 2.0 * std::log2(pixel_a / pixel_b) - *other);
    ++count;
  }
  return count < least_rings ? std::nullopt : std::optional(sum / count);
}

}  // namespace patinate::analysis
