/// \file
/// A painted image as control map.
#pragma once

#include "libcommon/controls/control_map.h"

namespace patinate {

/// An image laid over the atlas by UV: the whole image spans [0, 1]^2; bilinear when its size differs from the atlas'.
/// Values in [0, 1] stay as they are; if any is outside, they are normalised by their least and greatest, kept as low
/// and high.
/// @param image  h x w x 1, finite.
/// @throws InvalidInput if it is empty, has several channels, or holds NaN or infinity.
[[nodiscard]] ControlMap image_map(const TexelMap& map, const ImageF& image);

}  // namespace patinate
