/// \file
/// Two surfaces that show the same places, frame by frame.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "analysis/figures/color_stack.h"
#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// Difference at one compared time.
struct PixelDifference {
  double ciede2000_mean = 0.0;
  double ciede2000_median = 0.0;
  double ciede2000_p95 = 0.0;
  double absolute = 0.0;  ///< Mean over texels and channels of the difference of linear color.
  double ssim = 1.0;      ///< Mean over the texels, of L*.
};

/// CIEDE2000 of every texel at a pair of times.
/// @param a,b  The same texels. @throws InvalidInput if not, or a time is not there.
[[nodiscard]] std::vector<float> ciede2000_at(const ColorStack& a, std::size_t time_a, const ColorStack& b,
                                              std::size_t time_b);

/// @throws InvalidInput unless the stacks hold the same texels and as many times. Same bits for any number of threads.
[[nodiscard]] std::vector<PixelDifference> pixel_differences(const ColorStack& a, const ColorStack& b,
                                                             const RunControl& control = {});

/// Differences that the stated deviations of captures alone would cause.
struct StatedNoise {
  double ciede2000 = 0.0;     ///< Mean that equal surfaces would show by their deviations alone.
  double beyond_share = 0.0;  ///< Share of places and times that differ by more than 99 % of equal ones would.
};
/// @param a,b    The same texels and as many times; a side that states no deviation counts as exact.
/// @param seed   Of the draws.
/// @returns nothing when neither side states any. @throws InvalidInput as pixel_differences(). Same bits for any number
/// of threads.
[[nodiscard]] std::optional<StatedNoise> stated_noise(const ColorStack& a, const ColorStack& b, std::uint64_t seed,
                                                      const RunControl& control = {});

}  // namespace patinate::analysis
