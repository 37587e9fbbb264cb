/// \file
/// Printed markers that lie beside the object: marks that nobody needs to click.
#pragma once

#include "capture/handheld/landmarks.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Four corners of every ArUco or AprilTag marker [Garrido-Jurado et al. 2014; Olson 2011], to a fraction of a pixel,
/// by names as "4x4 7 corner 0". Of the dictionaries 4x4, 5x5, 6x6 and 7x7 (50 to 1000 markers), the original ArUco one
/// and AprilTag 36h11 that which names the most. A marker that is seen twice is left out.
/// @param color  H x W x 3, linear.
[[nodiscard]] PhotoMarks find_markers(const ImageF& color);

}  // namespace patinate::capture
