/// \file
/// What a ray has met of a mesh that is shaded: the corners of the triangle, and what follows from them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "libcommon/geometry/ray_scene.h"
#include "libcommon/output/glb_tangents.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

/// Corners of one triangle.
struct HitCorners {
  std::array<Vec3, 3> positions, normals;
  std::array<Vec2, 3> uvs;
  std::array<double, 3> open;  ///< Ambient visibility, [0, 1].
};

/// @param mesh  With normals and UVs. @param open  By position of the mesh.
[[nodiscard]] HitCorners corners_of(const Mesh& mesh, const std::vector<float>& open, std::size_t triangle);

/// The place on the smooth surface that the normals tell, where shadow rays begin so that coarse triangles do not shade
/// themselves [Hanika 2021]. @param side  1 on the side of the normals, -1 behind.
[[nodiscard]] Vec3 smooth_place(const HitCorners& corners, const RayHit& hit, double side);

/// A normal of a map in the frame of the smooth one. @param smooth  Unit. @param n  x along the tangent, y across it, z
/// along `smooth`; any length. @returns unit; `smooth` where there is no tangent or n has no length.
[[nodiscard]] Vec3 mapped_normal(const CornerTangents& tangents, const RayHit& hit, const Vec3& smooth, const Vec3& n);

}  // namespace patinate
