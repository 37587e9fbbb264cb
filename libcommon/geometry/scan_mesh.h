/// \file
/// The surface that a scan shows: its own triangles, or its range grid triangulated.
#pragma once

#include "patinate/geometry/mesh.h"
#include "patinate/geometry/point_cloud.h"

namespace patinate {

/// Edges of a range grid are excluded where they are longer than this many times the grid's median edge (with a known
/// scanner: the median share of the distance to it): there the surface jumps in depth, or is seen at more than 78
/// degrees from its normal.
inline constexpr double kDepthJumpFactor = 5.0;

/// The file's triangles as they are; else two triangles (split along the shorter diagonal) for four neighboring cells
/// of the grid, one for three, none across depth jumps; turned so that they face the scanner (direction_to_scanner())
/// where that is known. Positions are the cloud's points, index by index; normals are the cloud's, or none; one surface
/// without a name; no UVs.
/// @throws InvalidInput if the cloud has neither triangles nor a grid, or no triangle remains.
[[nodiscard]] Mesh mesh_of_scan(const PointCloud& cloud);

/// Whether a step between two neighboring cells of the grid is a depth jump, by the rule above.
class DepthJumps {
 public:
  /// @throws InvalidInput if the cloud has no grid, or no two neighboring cells hold points.
  explicit DepthJumps(const PointCloud& cloud);
  /// @param a, b  Points; not excluded.
  [[nodiscard]] bool operator()(int a, int b) const;
  /// Median edge of the grid, or its share of the distance to the scanner when that is known.
  [[nodiscard]] double median_edge() const { return median_edge_; }

 private:
  [[nodiscard]] double length(int a, int b) const;
  const PointCloud& cloud_;
  double median_edge_ = 0.0;
};

}  // namespace patinate
