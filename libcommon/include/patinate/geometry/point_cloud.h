/// \file
/// What a scanner measured: points in double precision, with the grid they were taken on when there was one.
#pragma once

#include <optional>
#include <vector>

#include "patinate/geometry/mesh.h"
#include "patinate/geometry/rigid_transform.h"

namespace patinate {

/// Plain arrays; every list but `points` is as long as points, or empty. Points that the scanner did not measure (NaN)
/// are excluded.
struct PointCloud {
  std::vector<Vec3> points;         ///< Finite; in the file's unit until scaled to mm.
  std::vector<Vec3> normals;        ///< Unit, towards the scanner. Empty until estimated, or as the file says them.
  std::vector<Vec3> colors;         ///< Red, green, blue as stored, divided by 255; empty when the file has none.
  std::vector<Triangle> triangles;  ///< Into points, when the file has faces; else empty.

  /// Range grid: which point lies at column x, row y: cell[y * width + x], -1 = nothing measured there.
  struct Grid {
    int width = 0;
    int height = 0;
    std::vector<int> cell;
  };
  std::optional<Grid> grid;
  std::optional<Vec3> scanner;  ///< Where the scanner stood, in the cloud's frame, when the file says it.

  std::optional<Vec3> toward_scanner;  ///< Unit; of a scanner that looks along parallel lines, when `scanner` is not
                                       ///< known (range grids).

  [[nodiscard]] int num_points() const { return static_cast<int>(points.size()); }
};

/// Multiplies positions.
void scale_cloud(PointCloud& cloud, double factor);
[[nodiscard]] Box bounding_box(const PointCloud& cloud);
/// Unit vector from a point to where the scanner stood: to `scanner` when it is known, else `toward_scanner`, else
/// nothing.
[[nodiscard]] std::optional<Vec3> direction_to_scanner(const PointCloud& cloud, const Vec3& point);
/// All of it moved: points, normals, scanner.
[[nodiscard]] PointCloud moved(PointCloud cloud, const RigidTransform& target_from_cloud);

}  // namespace patinate
