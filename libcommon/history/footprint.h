/// \file
/// What a texel shows that covers several pixels of a history: their mean, not one of them.
#pragma once

#include "patinate/image/image.h"

namespace patinate {

/// Up to here a texel shows one pixel, as it is: an average would blur more than it smooths.
inline constexpr double kLeastFootprint_px = 1.25;
inline constexpr double kLargestFootprint_px = 256.0;

/// Every pixel as the mean of the square of `footprint_px` around it, with a Gaussian of the same variance (pixels are
/// means over themselves already): sigma = sqrt((footprint_px^2 - 1) / 12), which no turn of a patch changes.
/// @param values  H x W x C. @param mask  H x W, what is 0 counts nowhere; may be empty.
/// @param footprint_px  [0, kLargestFootprint_px]; up to kLeastFootprint_px `values` come back as they are.
[[nodiscard]] ImageF mean_over_footprint(ImageF values, const ImageU8& mask, double footprint_px);

}  // namespace patinate
