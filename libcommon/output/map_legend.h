/// \file
/// What the colors of a map stand for.
#pragma once

#include <string>

#include "libcommon/output/color_ramp.h"

namespace patinate {

struct MapLegend {
  ColorRamp ramp = ColorRamp::Sequential;
  double low = 0.0;
  double high = 1.0;
  std::string unit = "";  ///< Behind the numbers: "um", "%"; ASCII.
  std::string more = "";  ///< Meaning of other colors: "gray: not measured"; ASCII, may be empty.
};

/// The picture above the ramp, with the numbers of its ends and of its middle.
/// @param picture  H x W x 3, linear. @returns the same width, or 160 px where it is narrower.
[[nodiscard]] ImageF with_legend(const ImageF& picture, const MapLegend& legend);

}  // namespace patinate
