/// \file
/// Two surfaces that show the same places, frame by frame.
#pragma once

#include <vector>

#include "analysis/figures/color_stack.h"
#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// Of one compared time.
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

}  // namespace patinate::analysis
