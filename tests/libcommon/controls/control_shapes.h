/// \file
/// Atlases of shapes whose control maps have closed forms.
#pragma once

#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/controls/control_map.h"
#include "tests/libcommon/geometry/shapes.h"

namespace patinate::testing_support {

/// Meshes that each fill the atlas, side by side in columns of one atlas.
[[nodiscard]] inline Mesh side_by_side(const std::vector<Mesh>& parts) {
  Mesh all;
  const double width = 1.0 / static_cast<double>(parts.size());
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const int p0 = static_cast<int>(all.positions.size()), t0 = static_cast<int>(all.uvs.size());
    const Mesh& part = parts[k];
    all.positions.insert(all.positions.end(), part.positions.begin(), part.positions.end());
    for (const Vec2& uv : part.uvs) all.uvs.emplace_back((static_cast<double>(k) + uv.x()) * width, uv.y());
    for (const Triangle& t : part.triangles) all.triangles.push_back({t[0] + p0, t[1] + p0, t[2] + p0});
    for (const Triangle& t : part.uv_triangles) all.uv_triangles.push_back({t[0] + t0, t[1] + t0, t[2] + t0});
  }
  all.triangle_surface.assign(all.triangles.size(), 0);
  all.surfaces.push_back({});
  return all;
}

/// A plane of `side` mm about the origin that faces +z and fills the atlas.
[[nodiscard]] inline Mesh plane(double side, int cells = 4) {
  return make_patch(cells, cells, [side](double u, double v) { return Vec3(side * (u - 0.5), side * (v - 0.5), 0); });
}

/// Two walls of `length` mm that meet at the y axis under the angle `phi` and open to +z; 100 times as long in y. The
/// left half of the atlas is the wall at x < 0, its columns from the bottom upwards.
[[nodiscard]] inline Mesh groove(double length, double phi) {
  const double x = length * std::sin(phi / 2), z = length * std::cos(phi / 2), y = 50 * length;
  return side_by_side({make_patch(8, 1, [=](double u, double v) { return Vec3(-u * x, y * (1 - 2 * v), u * z); }),
                       make_patch(8, 1, [=](double u, double v) { return Vec3(u * x, y * (2 * v - 1), u * z); })});
}

/// Physical value of a texel.
[[nodiscard]] inline double value_at(const ControlMap& control, TexelId t) {
  return control.low + (control.high - control.low) * static_cast<double>(control.values.values()[t]);
}

}  // namespace patinate::testing_support
