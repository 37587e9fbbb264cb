/// \file
/// The peaks of one smoothed histogram: where the highest is, how much belongs to it, and whether there is another.
#pragma once

#include <span>

namespace patinate::capture {

inline constexpr int kHistogramLanes = 8;  ///< Histograms are padded with 0 to whole groups of this many bins.
/// A value belongs to a peak within this many range sigmas of it: 98.8 % of what the smoothing itself spreads.
inline constexpr double kPeakSigmas = 2.5;

/// The highest bin of (1 - t) a + t b, which becomes `blended`. The lowest one wins a tie.
/// @param a,b  As many bins as `blended`, which has whole lanes.
[[nodiscard]] int highest_bin(const float* a, const float* b, float t, std::span<float> blended);

/// Position of the peak around bin `at`, by a parabola through the logarithms of three bins (exact for a Gaussian
/// peak).
[[nodiscard]] double refined_peak(std::span<const float> histogram, int at);

/// Parts of the whole histogram, [0, 1].
struct PeakShares {
  float first = 0.0f;   ///< What lies within `reach` of the highest bin.
  float second = 0.0f;  ///< The same of the other peak; 0 when there is none.
  int second_at = -1;   ///< Its highest bin; -1 when there is none.
};
/// The other peak is the highest one that shares no bin with the first and is parted from it by a valley of less than
/// half of its own height: the flank of a broad or sloping histogram is none.
/// @param at     highest_bin(). @param reach  Bins on either side that belong to a peak; >= 1.
[[nodiscard]] PeakShares peak_shares(std::span<const float> histogram, int at, int reach);

}  // namespace patinate::capture
