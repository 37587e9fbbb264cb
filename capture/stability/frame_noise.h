/// \file
/// The noise of a series of photographs, from the series itself: what a frame differs by from the frames before and
/// after it.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Fewest frames that tell noise from aging: three are compared with their neighbors.
inline constexpr int kMinForNoise = 5;

/// Standard deviation of a frame's color where it is v: at(place) * sqrt((offset + slope v) / (offset + slope mean)).
struct SeriesNoise {
  ImageF level;                             ///< H x W x 3, linear: standard deviation at the place's mean color.
  ImageF mean;                              ///< H x W x 3: that color.
  std::array<double, 3> offset{}, slope{};  ///< Variance over the picture as offset + slope * color; both >= 0.

  /// @param frame  H x W x 3, linear. @returns H x W x 3. @throws InvalidInput if sizes differ.
  [[nodiscard]] ImageF deviation_of(const ImageF& frame) const;
};

/// A frame against the straight line in time between its neighbors, without what of that is slow over the picture
/// (Gaussian of 4 px: aging that bends): what is left is noise, with the variance 1 + a^2 + b^2 for weights a + b = 1.
/// Mean of the square root of its size over time, median of 5 x 5 pixels: jumps (a crack that opens) count little. What
/// whole photographs have wrong, flicker, the response or the lamp, does not show.
/// @param times       Increasing, kMinForNoise or more. @param read_frame  Frame i, H x W x 3; read once, in order.
/// @throws InvalidInput if there are fewer, or sizes differ. Memory does not depend on the number of frames.
[[nodiscard]] SeriesNoise estimate_noise(const std::vector<double>& times, const std::function<ImageF(int)>& read_frame,
                                         const RunControl& control = {});

}  // namespace patinate::capture
