/// \file
/// Whether equal pixels of two surfaces show equal places, judged by what they show.
#pragma once

#include "analysis/figures/color_stack.h"

namespace patinate::analysis {

/// How much of their detail two surfaces share, pixel by pixel, and how much by chance.
struct SharedDetail {
  double correlation =
      0.0;  ///< Correlation of lightness over its local mean, [-1, 1]; the larger of the first and the last time.
  double by_chance = 1.0;  ///< Its largest magnitude when B is shifted by eighths of its sides.
  /// Twice as much as by chance, and a tenth or more.
  [[nodiscard]] bool is_clear() const { return correlation >= 0.1 && correlation >= 2.0 * by_chance; }
};
/// @param a,b  Of one size; with any masks. 0 where one of them has no detail.
[[nodiscard]] SharedDetail shared_detail(const ColorStack& a, const ColorStack& b);

/// Whether both have the charts of one atlas: masks that agree in 999 of 1000 texels and are no full rectangle.
[[nodiscard]] bool have_same_charts(const ColorStack& a, const ColorStack& b);

}  // namespace patinate::analysis
