/// \file
/// Sizes that are scaled until their sum is the one asked for.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

namespace patinate::datasets {

/// Factor at which a size that grows with it comes nearest to what is wanted.
/// @param size_at  Never falls; 0 at 0, about as the square of its argument.
template <class SizeAt>
[[nodiscard]] double fitted_factor(double wanted, const SizeAt& size_at) {
  constexpr int kMaxSteps = 40;
  constexpr double kCloseEnough = 1e-4;  ///< Share of what is wanted.
  double low = 0.0, high = 1.0, at_low = 0.0, at_high = size_at(high);
  for (int i = 0; i < kMaxSteps && at_high < wanted; ++i) {
    low = std::exchange(high, 1.3 * high);
    at_low = std::exchange(at_high, size_at(high));
  }
  for (int i = 0; i < kMaxSteps; ++i) {
    if (std::abs(at_low - wanted) <= kCloseEnough * wanted) return low;
    if (std::abs(at_high - wanted) <= kCloseEnough * wanted) return high;
    // Its square by the chord, but never so near an end that the other would stay.
    const double share = at_high > at_low ? std::clamp((wanted - at_low) / (at_high - at_low), 0.05, 0.95) : 0.5;
    const double middle = std::sqrt(low * low + share * (high * high - low * low)), at_middle = size_at(middle);
    (at_middle < wanted ? low : high) = middle;
    (at_middle < wanted ? at_low : at_high) = at_middle;
  }
  return wanted - at_low < at_high - wanted ? low : high;
}

}  // namespace patinate::datasets
