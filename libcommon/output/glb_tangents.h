/// \file
/// Tangents of a mesh's corners, for normal maps.
#pragma once

#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Tangents of every corner of every triangle.
struct CornerTangents {
  std::vector<std::array<Vec3, 3>> tangent;  ///< Unit, at right angles to the corner's normal, along growing u.
  std::vector<bool> is_mirrored;  ///< By triangle: growing v (up) is along tangent x normal, not normal x tangent.
};

/// Directions of growing u, angle-weighted over the triangles that share position, UV, normal and side, as MikkTSpace
/// does it [Mikkelsen 2008, "Simulation of wrinkled surfaces revisited"]. Any direction at right angles to the normal
/// where UVs have no area.
/// @param mesh  With UVs and normals at every corner.
[[nodiscard]] CornerTangents corner_tangents(const Mesh& mesh);

}  // namespace patinate
