/// \file
/// What a photograph of 8 bits leaves of a value.
#pragma once

#include "patinate/image/color.h"

namespace patinate::testing_support {

/// How far a linear value in [0, 1] may be off after it was written as an sRGB code of 8 bits and kept as half float.
inline double photo_rounding(double value) {
  const double code = static_cast<double>(srgb_from_linear(static_cast<float>(value)));
  return static_cast<double>(linear_from_srgb(static_cast<float>(code + 0.5 / 255.0))) - value + value / 2048.0;
}

}  // namespace patinate::testing_support
