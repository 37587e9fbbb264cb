/// \file
/// The pinhole camera with Brown distortion as a template, for automatic differentiation. camera.h has the formula and
/// the checks.
#pragma once

namespace patinate::capture {

/// Pixel of a point in the camera's frame, z > 0. @param focal_center  fx fy cx cy. @param lens  k1 k2 p1 p2 k3.
template <class T, class U>
void project_brown(const T* focal_center, const T* lens, const U* x_in_camera, U* pixel) {
  const U x = x_in_camera[0] / x_in_camera[2], y = x_in_camera[1] / x_in_camera[2];
  const U r2 = x * x + y * y, xy = x * y;
  const U radial = U(1.0) + r2 * (U(lens[0]) + r2 * (U(lens[1]) + r2 * U(lens[4])));
  pixel[0] = U(focal_center[0]) * (x * radial + U(2.0) * U(lens[2]) * xy + U(lens[3]) * (r2 + U(2.0) * x * x)) +
             U(focal_center[2]);
  pixel[1] = U(focal_center[1]) * (y * radial + U(lens[2]) * (r2 + U(2.0) * y * y) + U(2.0) * U(lens[3]) * xy) +
             U(focal_center[3]);
}

}  // namespace patinate::capture
