/// \file
/// Parts of a panel's picture as masks.
#pragma once

#include <vector>

#include "patinate/image/image.h"

namespace patinate::analysis {

/// Keeps the pixels at least `edge_px` from the outside of the mask and of the picture.
[[nodiscard]] ImageU8 without_edge(const ImageU8& mask, double edge_px);

/// Mask of a polygon. @param corners_mm  x, y of three corners or more. @throws InvalidInput if it lies outside.
[[nodiscard]] ImageU8 polygon_mask(int width, int height, double pixel_mm, const std::vector<double>& corners_mm);

}  // namespace patinate::analysis
