/// \file
/// Pictures that show how well a calibration fits.
#pragma once

#include <vector>

#include "patinate/capture/camera_calibration.h"
#include "patinate/capture/sphere_lights.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Every point of every view as a dot, a line from it along its residual, so much longer that the typical one is a
/// fortieth of the picture. At most 1200 pixels wide, linear RGB.
[[nodiscard]] ImageF view_residuals_picture(const CameraCalibration& calibration, const std::vector<PointView>& views);

/// A photograph, darkened, with the outlines of spheres as fitted and a cross at every highlight, one color a light. At
/// most 1200 pixels wide.
/// @param photo  May be empty: a gray ground of the camera's size.
[[nodiscard]] ImageF spheres_picture(const ImageF& photo, const Camera& camera_mm, const std::vector<SphereFit>& fits,
                                     const std::vector<MirrorSphere>& spheres, const Highlights& highlights);

}  // namespace patinate::capture
