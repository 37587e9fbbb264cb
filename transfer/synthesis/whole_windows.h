/// \file
/// How much of a source can be compared: pixels whose whole neighborhood is inside its mask.
#pragma once

#include <cstdint>

#include "patinate/image/image.h"

namespace patinate::transfer {

/// Pixels around which all of 2 * radius_px + 1 rows and columns lies in the image and inside the mask.
/// @param mask  0 = outside. @param radius_px  >= 0.
[[nodiscard]] std::int64_t num_whole_windows(const ImageU8& mask, int radius_px);

/// Least number that makes a transfer: those of a square of twice the window's side, less one. All windows of a smaller
/// one overlap.
[[nodiscard]] constexpr std::int64_t least_whole_windows(int radius_px) {
  return std::int64_t{2 * radius_px + 1} * (2 * radius_px + 1);
}

}  // namespace patinate::transfer
