/// \file
/// Lines and regions of a mask, pixel by pixel: what measuring networks of cracks is made of.
#pragma once

#include <vector>

#include "libcommon/image/thinned_lines.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

struct PixelPlace {
  int x = 0, y = 0;
};

/// Pixels of every connected part of what is set, parts and their first pixels in reading order.
[[nodiscard]] std::vector<std::vector<PixelPlace>> parts_of(const ImageU8& image, bool with_diagonals);

/// Length of center lines that begins at a pixel: steps to the right and down, weighted so that straight lines of all
/// directions come out right on average [Vossepoel and Smeulders 1982]. The sum over a picture is the same for its
/// mirror image. @param lines  As thinned() gives it; set at (x, y).
[[nodiscard]] double length_from(const ImageU8& lines, int x, int y);

/// Centers of groups of junction pixels no further apart than `reach`. @param groups  Is given their pixels.
[[nodiscard]] std::vector<PixelPlace> junction_centers(const ImageU8& lines, double reach,
                                                       std::vector<std::vector<PixelPlace>>& groups);

}  // namespace patinate::analysis
