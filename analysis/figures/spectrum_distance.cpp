#include "analysis/figures/spectrum_distance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace patinate::analysis {

namespace {

constexpr double kFaint = 1e-6;  ///< L*^2: keeps the logarithm of nothing finite; far below what a photograph resolves.

/// Where a frequency lies: in a ring, or a share of the way to the next one.
struct RingPlace {
  std::size_t ring = 0;
  double share = 0.0;
};
std::optional<RingPlace> place_of(const Spectrum& spectrum, double frequency) {
  if (spectrum.power.empty()) return std::nullopt;
  double at = 2.0 * std::log2(frequency / spectrum.frequencies.front());
  if (std::abs(at - std::round(at)) < 1e-9) at = std::round(at);  // Same ring: nothing to blend.
  if (at < 0.0 || at > static_cast<double>(spectrum.power.size() - 1)) return std::nullopt;
  const auto ring = static_cast<std::size_t>(at);
  return RingPlace{.ring = ring, .share = at - static_cast<double>(ring)};
}

}  // namespace

std::optional<double> log_power(const Spectrum& spectrum, double frequency) {
  const std::optional<RingPlace> at = place_of(spectrum, frequency);
  if (!at) return std::nullopt;
  const double low = std::log2(spectrum.power[at->ring] + kFaint);
  return at->share > 0.0 ? (1.0 - at->share) * low + at->share * std::log2(spectrum.power[at->ring + 1] + kFaint) : low;
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

std::optional<double> contrast_between(const Spectrum& a, double pixel_a, const Spectrum& b, double pixel_b) {
  const auto contrast = [](double power, double frequency) {
    return std::sqrt(std::numbers::pi / std::numbers::sqrt2 * power) * frequency;
  };
  double sum = 0.0;
  bool has_any = false;
  for (std::size_t k = 0; k < a.power.size(); ++k) {
    const double frequency = a.frequencies[k] / pixel_a * pixel_b;  // In b's pixels.
    const std::optional<RingPlace> at = place_of(b, frequency);
    if (!at) continue;
    const double power =
        at->share > 0.0 ? std::max(0.0, std::exp2(*log_power(b, frequency)) - kFaint) : b.power[at->ring];
    sum += std::pow(contrast(a.power[k], a.frequencies[k]) - contrast(power, frequency), 2);
    has_any = true;
  }
  return has_any ? std::optional(std::sqrt(sum)) : std::nullopt;
}

}  // namespace patinate::analysis
