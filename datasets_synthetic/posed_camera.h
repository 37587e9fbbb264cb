/// \file
/// Where the cameras of synthetic captures stand.
#pragma once

#include "patinate/geometry/camera.h"

namespace patinate::datasets {

/// Looks from one point at another, upright, its principal point in the middle of the picture. Focal lengths and
/// distortion are the caller's.
[[nodiscard]] inline CameraParameters posed_camera(const Vec3& eye, const Vec3& target, int width, int height) {
  CameraParameters p;
  p.width = width;
  p.height = height;
  const Vec3 forward = (target - eye).normalized(), right = Vec3::UnitX(), down = forward.cross(right);
  p.rotation.row(0) = right;
  p.rotation.row(1) = down;
  p.rotation.row(2) = forward;
  p.translation = -(p.rotation * eye);
  p.cx = 0.5 * (width - 1);
  p.cy = 0.5 * (height - 1);
  return p;
}

}  // namespace patinate::datasets
