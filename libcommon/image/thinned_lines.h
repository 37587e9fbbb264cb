/// \file
/// Lines of a mask, one pixel wide.
#pragma once

#include <array>

#include "patinate/image/image.h"

namespace patinate {

/// Steps to the eight neighbors, clockwise from above.
inline constexpr int kAroundX[8] = {0, 1, 1, 1, 0, -1, -1, -1}, kAroundY[8] = {-1, -1, 0, 1, 1, 1, 0, -1};

/// Outside the image nothing is set.
[[nodiscard]] bool is_set(const ImageU8& image, int x, int y);
/// In the order of kAroundX.
[[nodiscard]] std::array<bool, 8> set_neighbors(const ImageU8& image, int x, int y);
/// Times that a walk around a pixel enters the set: branches of a line.
[[nodiscard]] int num_branches(const std::array<bool, 8>& neighbors);

/// One pixel wide center lines, 8-connected [Zhang and Suen 1984], without the stairs that their method leaves of
/// slanted lines. @param mask  H x W, not 0 = on a line.
[[nodiscard]] ImageU8 thinned(const ImageU8& mask);

}  // namespace patinate
