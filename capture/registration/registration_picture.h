/// \file
/// What registration did, as a picture: the scans before and after, each in its color, from aside and cut through.
#pragma once

#include <span>

#include "patinate/geometry/point_cloud.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/image/image.h"

namespace patinate::capture {

struct RegistrationPictureOptions {
  int panel_px = 520;      ///< Width and height of each of the four panels; [64, 4096].
  double turn_deg = 25.0;  ///< Of the view about the upright axis (y), from the first scan's line of sight.
  double tilt_deg = 15.0;  ///< From above.
};

/// Left as it was, right as it is; above all points that the viewer sees, shaded by their depth; below those within a
/// thin slice through the middle, seen along y.
/// @param before, after  common from scan, as many as scans. @returns linear, 3 channels. @throws InvalidInput if
/// numbers differ or there is no point
[[nodiscard]] ImageF registration_picture(std::span<const PointCloud> scans, std::span<const RigidTransform> before,
                                          std::span<const RigidTransform> after,
                                          const RegistrationPictureOptions& options = {});

}  // namespace patinate::capture
