/// \file
/// Color for the gutters between charts.
#pragma once

#include "patinate/image/image.h"

namespace patinate {

/// Fills texels outside the charts from the nearest covered one (GutterFill), up to `radius` texels away (any distance
/// when < 0), so that filtering at chart borders does not bleed. On one thread.
/// @param coverage  0 = to be filled.
void dilate(ImageF& image, const ImageU8& coverage, int radius);
void dilate(ImageU8& image, const ImageU8& coverage, int radius);

}  // namespace patinate
