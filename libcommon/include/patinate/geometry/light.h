/// \file
/// A photograph's light: near or distant, in scanner coordinates.
#pragma once

#include <string>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// One lamp of a rig. The linear value that a Lambertian surface shows is `albedo / pi * intensity * max(0, n . l)`,
/// divided by d^2 in mm^2 for a near light.
struct Light {
  enum class Kind { Near, Directional };
  Kind kind = Kind::Near;
  Vec3 position = Vec3::Zero();    ///< Near: where it stands, mm, in the scanner's frame.
  Vec3 direction = Vec3(0, 0, 1);  ///< Directional: unit, from the surface to the light, in the scanner's frame.
  Vec3 intensity = Vec3::Ones();   ///< Red, green, blue; > 0. Near: value x mm^2.
  bool is_intensity_known = true;  ///< False when its file gives none: intensity is 1 then, and stands for nothing.
  std::string name;                ///< As the file says it; may be empty.
};

/// Unit vector from a surface point to the light. Undefined at the light itself.
[[nodiscard]] inline Vec3 direction_to(const Light& light, const Vec3& point) {
  return light.kind == Light::Kind::Near ? Vec3((light.position - point).normalized()) : light.direction;
}
/// Red, green, blue that reach a surface at `point` that faces the light: intensity, over d^2 for a near one.
[[nodiscard]] inline Vec3 light_at(const Light& light, const Vec3& point) {
  return light.kind == Light::Kind::Near ? Vec3(light.intensity / (light.position - point).squaredNorm())
                                         : light.intensity;
}

}  // namespace patinate
