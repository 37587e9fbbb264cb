/// \file
/// Surfaces whose scans are known exactly.
#pragma once

#include <cstdint>
#include <functional>

#include "patinate/geometry/point_cloud.h"

namespace patinate::testing_support {

/// A range grid of `size` x `size` cells over 100 mm x 100 mm, seen from +z: (x, y, height(x, y)).
struct GridScan {
  int size = 120;
  double offset = 0.0;    ///< Offset of the whole grid along x and y, in cells: other points of the same surface.
  double noise_mm = 0.0;  ///< Standard deviation along z.
  std::uint64_t seed = 1;
};
[[nodiscard]] PointCloud scan_of(const std::function<double(double x, double y)>& height, const GridScan& grid = {});

/// A relief without any symmetry: hills, furrows and a tilted rim; heights of about 20 mm.
[[nodiscard]] double relief(double x, double y);

/// The parts of a scan that `keeps` holds for, without its grid.
[[nodiscard]] PointCloud part_of(const PointCloud& cloud, const std::function<bool(const Vec3&)>& keeps);
/// x mirrored.
[[nodiscard]] PointCloud mirrored(PointCloud cloud);

/// Largest distance that any point of `cloud` is moved to by one transform and not by the other.
[[nodiscard]] double largest_gap(const PointCloud& cloud, const RigidTransform& a, const RigidTransform& b);

}  // namespace patinate::testing_support
