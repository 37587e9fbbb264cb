/// \file
/// Colour for the gutters between charts.
#pragma once

#include "libcommon/image/image.h"

namespace patinate {

/// Fills texels outside the charts from the nearest covered one, up to `radius` texels away (as far as 16,384 when < 0), so that
/// filtering at chart borders does not bleed.
/// @param coverage  0 = to be filled.
void dilate(ImageF& image, const ImageU8& coverage, int radius);
void dilate(ImageU8& image, const ImageU8& coverage, int radius);

}  // namespace patinate
