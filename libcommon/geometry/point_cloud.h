/// \file
/// What a scanner measured: points in double precision, with the grid they were taken on when there was one.
#pragma once

#include <optional>
#include <vector>

#include "libcommon/geometry/mesh.h"

namespace patinate {

/// Plain arrays; every list but `points` is as long as points, or empty. Points that the scanner did not measure (NaN) are left out.
struct PointCloud {
  std::vector<Vec3> points;    ///< Finite; in the file's unit until scaled to mm.
  std::vector<Vec3> normals;   ///< Unit, towards the scanner. Empty until estimated, or as the file says them.
  std::vector<Vec3> colors;    ///< Red, green, blue as stored, divided by 255; empty when the file has none.
  std::vector<Triangle> triangles;  ///< Into points, when the file has faces; else empty.

  /// Range grid: which point lies at column x, row y: cell[y * width + x], -1 = nothing measured there.
  struct Grid {
    int width = 0;
    int height = 0;
    std::vector<int> cell;
  };
  std::optional<Grid> grid;
  std::optional<Vec3> scanner;  ///< Where the scanner stood, in the cloud's frame, when the file says it.

  [[nodiscard]] int num_points() const { return static_cast<int>(points.size()); }
};

/// Multiplies positions.
void scale_cloud(PointCloud& cloud, double factor);
[[nodiscard]] Box bounding_box(const PointCloud& cloud);

}  // namespace patinate
