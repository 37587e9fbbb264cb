#include "libcommon/history/footprint.h"

#include <cmath>

#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate {

ImageF mean_over_footprint(ImageF values, const ImageU8& mask, double footprint_px) {
  if (!(footprint_px >= 0.0 && footprint_px <= kLargestFootprint_px))
    throw InvalidInput("footprint: use 0 to 256 pixels");
  if (footprint_px <= kLeastFootprint_px) return values;
  return gaussian_blur(values, mask, std::sqrt((footprint_px * footprint_px - 1.0) / 12.0));
}

}  // namespace patinate
