/// \file
/// Lines and regions of a mask, pixel by pixel: what measuring networks of cracks is made of.
#pragma once

#include <array>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::analysis {

/// Steps to the eight neighbors, clockwise from above.
inline constexpr int kAroundX[8] = {0, 1, 1, 1, 0, -1, -1, -1}, kAroundY[8] = {-1, -1, 0, 1, 1, 1, 0, -1};

struct PixelPlace {
  int x = 0, y = 0;
};

/// Outside the image nothing is set.
[[nodiscard]] bool is_set(const ImageU8& image, int x, int y);
/// In the order of kAroundX.
[[nodiscard]] std::array<bool, 8> set_neighbors(const ImageU8& image, int x, int y);
/// Times that a walk around a pixel enters the set: branches of a line.
[[nodiscard]] int num_branches(const std::array<bool, 8>& neighbors);

/// Pixels of every connected part of what is set, parts and their first pixels in reading order.
[[nodiscard]] std::vector<std::vector<PixelPlace>> parts_of(const ImageU8& image, bool with_diagonals);

/// One pixel wide center lines, 8-connected [Zhang and Suen 1984], without the stairs that their method leaves of
/// slanted lines. @param cracks  H x W, not 0 = crack.
[[nodiscard]] ImageU8 thinned(const ImageU8& cracks);

/// Length of center lines that begins at a pixel: steps to the right and down, weighted so that straight lines of all
/// directions come out right on average [Vossepoel and Smeulders 1982]. The sum over a picture is the same for its
/// mirror image. @param lines  As thinned() gives it; set at (x, y).
[[nodiscard]] double length_from(const ImageU8& lines, int x, int y);

/// Centers of groups of junction pixels no further apart than `reach`. @param groups  Is given their pixels.
[[nodiscard]] std::vector<PixelPlace> junction_centers(const ImageU8& lines, double reach,
                                                       std::vector<std::vector<PixelPlace>>& groups);

}  // namespace patinate::analysis
