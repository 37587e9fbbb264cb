/// \file
/// The camera of render().
#pragma once

#include "patinate/geometry/mesh.h"
#include "patinate/output/render.h"

namespace patinate {

/// Pinhole camera that looks along -backward. Unit, right-handed axes.
struct OrbitCamera {
  Vec3 position = Vec3::Zero();
  Vec3 right = Vec3::UnitX();
  Vec3 up = Vec3::UnitY();
  Vec3 backward = Vec3::UnitZ();
  double tan_x = 0.25;  ///< Tangent of half the horizontal field of view.
  double tan_y = 0.25;

  /// Unit direction through a place in the picture: u to the right, v down, [0, 1].
  [[nodiscard]] Vec3 direction(double u, double v) const {
    return ((2.0 * u - 1.0) * tan_x * right + (1.0 - 2.0 * v) * tan_y * up - backward).normalized();
  }
};

/// A direction given for y up, in the mesh's axes: (x, y, z) -> (x, -z, y) when z is up.
[[nodiscard]] inline Vec3 world_from_y_up(const Vec3& d, UpAxis up) {
  return up == UpAxis::Y ? d : Vec3(d.x(), -d.z(), d.y());
}

/// The camera that shows the whole mesh, as large as the margin allows, its outline centered, then zoomed.
[[nodiscard]] OrbitCamera fitted_camera(const Mesh& mesh, const RenderOptions& options);

}  // namespace patinate
