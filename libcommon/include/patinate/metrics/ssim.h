/// \file
/// Structural similarity of two images.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate {

/// SSIM of every pixel [Wang, Bovik, Sheikh, Simoncelli 2004], in [-1, 1], 1 for equal windows: 11 x 11 Gaussian window
/// of 1.5 px, K1 = 0.01, K2 = 0.03. At the border and beside what the mask leaves out, the weights inside are brought
/// to sum 1.
/// @param a,b    H x W x 1, finite. @param mask  H x W, 0 = outside; may be empty. @param range  Of the values (255, 1,
/// 100 for L*); > 0.
/// @returns H x W x 1; 0 outside the mask.
/// @throws InvalidInput if sizes or channels differ or the range is not > 0. Cost: O(22 H W). Same bits for any number
/// of threads.
[[nodiscard]] ImageF ssim_map(const ImageF& a, const ImageF& b, const ImageU8& mask, double range,
                              const RunControl& control = {});

}  // namespace patinate
