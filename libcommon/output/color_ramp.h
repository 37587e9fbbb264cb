/// \file
/// Numbers as colors that people with any color vision tell apart: straight lines in CIELAB, so that equal steps look
/// equal.
#pragma once

#include <array>

#include "patinate/image/image.h"

namespace patinate {

enum class ColorRamp {
  Sequential,  ///< Dark blue over gray to yellow, lighter all the way: survives red-green blindness and gray print.
  Diverging,   ///< Blue, white in the middle, orange: for numbers with a sign.
};

/// Linear color. @param x  In [0, 1]; clamped.
[[nodiscard]] std::array<float, 3> ramp_color(ColorRamp ramp, double x);

/// A map as a picture. @param values  H x W x 1. @param mask  0 = drawn in mid gray; may be empty. @param low,high
/// Values of the ramp's ends.
/// @throws InvalidInput if sizes differ, or low is not below high.
[[nodiscard]] ImageF ramp_picture(const ImageF& values, const ImageU8& mask, double low, double high, ColorRamp ramp);

}  // namespace patinate
