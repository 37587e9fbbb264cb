/// \file
/// Steps of unwrap(), 1: what they see of a mesh.
#pragma once

#include <array>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// A mesh at unit area, centered, with the neighbors over which a chart may grow.
struct UnwrapSurface {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  /// Triangle across the edge (corner k, corner k+1); -1 where the surface ends, more than two meet, or windings
  /// disagree.
  std::vector<std::array<int, 3>> neighbors;
  std::vector<Vec3> normals;    ///< Unit, per triangle; of a triangle without area, its neighbors'.
  std::vector<Vec3> centroids;  ///< Per triangle.
  std::vector<double> areas;    ///< Per triangle; their sum is 1.
  std::vector<bool> is_point;   ///< Repeated corners, or part of a piece without area: gets one point of the atlas.
  double area = 0.0;            ///< Area of the mesh, in its own units.

  /// Whether a triangle has area and is no sliver that flat() widens.
  [[nodiscard]] bool has_shape(int triangle) const;
  [[nodiscard]] int num_triangles() const { return static_cast<int>(triangles.size()); }
  /// The corners laid in the plane, counter-clockwise, the longest side along +x from the origin. Slivers are given a
  /// height of 1e-4 of their longest side, so that no angle is lost.
  [[nodiscard]] std::array<Vec2, 3> flat(int triangle) const;
};

/// @throws InvalidInput if there are no triangles, no area, or a position is not finite.
[[nodiscard]] UnwrapSurface make_unwrap_surface(const Mesh& mesh);

/// The corner (0, 1, 2) of a triangle at which it has this position.
[[nodiscard]] std::size_t corner_of(const Triangle& triangle, int position);

/// Triangles of a set split where no edge connects them; each part ascending, parts by their lowest triangle.
/// @param part_of  Per triangle; triangles are connected where equal. Only those in `triangles` are looked at.
[[nodiscard]] std::vector<std::vector<int>> connected_parts(const UnwrapSurface& surface,
                                                            const std::vector<int>& triangles,
                                                            const std::vector<int>& part_of);

}  // namespace patinate
