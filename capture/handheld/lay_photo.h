/// \file
/// A photograph as the reference photograph's camera would have it: resampled once, at the right footprint.
#pragma once

#include <Eigen/Core>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Length of one of the reference's pixels in the photograph's, in the middle of the photograph: over 1 where the
/// photograph is finer.
[[nodiscard]] double fineness(const Eigen::Matrix3d& reference_from_photo, int photo_width, int photo_height);

/// out(x, y) = the mean of the photograph over the pixel's footprint in it: of k x k cubic samples, where a footprint
/// is up to k of the photograph's pixels long (after whole ones were averaged where it is longer than 4). Not finer
/// than the reference, the photograph is sampled by Catmull-Rom cubics as resample_frame() does.
/// @param shown  Becomes width x height: 255 where the photograph reaches all of the footprint, else 0 (the nearest
/// values are stored).
/// @param photo  H x W x 1 or 3. @param reference_from_photo  Of pixel centers; must be invertible.
/// @throws InvalidInput if either is not so.
[[nodiscard]] ImageF lay_photo(const ImageF& photo, const Eigen::Matrix3d& reference_from_photo, int width, int height,
                               ImageU8& shown, const RunControl& control = {});

}  // namespace patinate::capture
