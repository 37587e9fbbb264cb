/// \file
/// How different two colors and two images look, and colors from how they look.
#pragma once

#include <array>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate {

/// CIEDE2000 difference of two CIELAB colors, k_L = k_C = k_H = 1 [Sharma, Wu, Dalal 2005]. >= 0, symmetric, 0 for
/// equal colors; about 1 is just noticeable side by side. Jumps where hues are opposite (their note 4).
/// @param a,b  L*, a*, b*; finite.
[[nodiscard]] double ciede2000(const std::array<double, 3>& a, const std::array<double, 3>& b);

/// Linear Rec.709 color of a CIELAB color under D65: the inverse of lab_from_linear(), not clamped.
[[nodiscard]] std::array<double, 3> linear_from_lab(const std::array<double, 3>& lab);

/// SSIM of every pixel [Wang, Bovik, Sheikh, Simoncelli 2004], in [-1, 1], 1 for equal windows: 11 x 11 Gaussian window
/// of 1.5 px, K1 = 0.01, K2 = 0.03. At the border and beside masked pixels, the weights of the remaining pixels are
/// scaled so that their sum is 1.
/// @param a,b    H x W x 1, finite. @param mask  H x W, 0 = outside; may be empty. @param range  Range of the values
/// (255, 1, or 100 for L*); > 0.
/// @returns H x W x 1; 0 outside the mask.
/// @throws InvalidInput if sizes or channels differ or the range is not > 0. Cost: O(22 H W). Same bits for any number
/// of threads.
[[nodiscard]] ImageF ssim_map(const ImageF& a, const ImageF& b, const ImageU8& mask, double range,
                              const RunControl& control = {});

}  // namespace patinate
