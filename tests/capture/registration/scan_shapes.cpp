#include "tests/capture/registration/scan_shapes.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/random.h"

namespace patinate::testing_support {

PointCloud scan_of(const std::function<double(double, double)>& height, const GridScan& grid) {
  PointCloud cloud;
  cloud.grid = PointCloud::Grid{grid.size, grid.size, {}};
  cloud.toward_scanner = Vec3(0, 0, 1);
  const double step = 100.0 / grid.size;
  for (int j = 0; j < grid.size; ++j) {
    for (int i = 0; i < grid.size; ++i) {
      RandomStream random(grid.seed, static_cast<std::uint64_t>(j * grid.size + i), 3);
      const double x = (i + grid.offset) * step - 50.0, y = (j + grid.offset) * step - 50.0, z = height(x, y);
      cloud.grid->cell.push_back(std::isfinite(z) ? cloud.num_points() : -1);
      if (std::isfinite(z)) cloud.points.emplace_back(x, y, z + grid.noise_mm * random.normal());
    }
  }
  return cloud;
}

double relief(double x, double y) {
  const auto hill = [&](double cx, double cy, double width, double tall) {
    return tall * std::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (width * width));
  };
  return hill(-18, 12, 16, 14) + hill(25, 20, 11, 9) + hill(10, -24, 14, -11) + hill(-30, -28, 9, 7) +
         1.2 * std::sin(0.31 * x + 0.12 * y) + 0.08 * x - 0.002 * y * y;
}

PointCloud part_of(const PointCloud& cloud, const std::function<bool(const Vec3&)>& keeps) {
  PointCloud part;
  part.toward_scanner = cloud.toward_scanner;
  part.scanner = cloud.scanner;
  for (const Vec3& p : cloud.points) {
    if (keeps(p)) part.points.push_back(p);
  }
  return part;
}

PointCloud mirrored(PointCloud cloud) {
  for (Vec3& p : cloud.points) p.x() = -p.x();
  if (cloud.toward_scanner) cloud.toward_scanner->x() *= -1.0;
  return cloud;
}

double largest_gap(const PointCloud& cloud, const RigidTransform& a, const RigidTransform& b) {
  double gap = 0.0;
  for (const Vec3& p : cloud.points) gap = std::max(gap, (a.apply(p) - b.apply(p)).norm());
  return gap;
}

}  // namespace patinate::testing_support
