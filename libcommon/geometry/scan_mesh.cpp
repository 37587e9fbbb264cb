#include "libcommon/geometry/scan_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "libcommon/core/median.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

const Vec3& at(const PointCloud& cloud, int i) { return cloud.points[i]; }

int cell(const PointCloud::Grid& grid, int x, int y) {
  return grid.cell[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x)];
}

/// Triangles of the grid, all with the winding of (x, y), (x + 1, y), (x, y + 1).
std::vector<Triangle> grid_triangles(const PointCloud& cloud) {
  const DepthJumps jumps(cloud);
  const PointCloud::Grid& grid = *cloud.grid;
  std::vector<Triangle> triangles;
  const auto add = [&](int a, int b, int c) {
    if (a == b || b == c || c == a || jumps(a, b) || jumps(b, c) || jumps(c, a)) return;
    triangles.push_back({a, b, c});
  };
  for (int y = 0; y + 1 < grid.height; ++y) {
    for (int x = 0; x + 1 < grid.width; ++x) {
      const std::array<int, 4> q{cell(grid, x, y), cell(grid, x + 1, y), cell(grid, x + 1, y + 1),
                                 cell(grid, x, y + 1)};  // around the cell
      const auto missing = std::count(q.begin(), q.end(), -1);
      if (missing > 1) continue;
      if (missing == 1) {
        const auto hole = static_cast<std::size_t>(std::find(q.begin(), q.end(), -1) - q.begin());
        add(q[(hole + 1) % 4], q[(hole + 2) % 4], q[(hole + 3) % 4]);
      } else if ((at(cloud, q[0]) - at(cloud, q[2])).squaredNorm() <=
                 (at(cloud, q[1]) - at(cloud, q[3])).squaredNorm()) {
        add(q[0], q[1], q[2]);
        add(q[0], q[2], q[3]);
      } else {
        add(q[0], q[1], q[3]);
        add(q[1], q[2], q[3]);
      }
    }
  }
  return triangles;
}

}  // namespace

DepthJumps::DepthJumps(const PointCloud& cloud) : cloud_(cloud) {
  if (!cloud.grid) throw InvalidInput("scan: it has no range grid");
  std::vector<double> lengths;
  const PointCloud::Grid& grid = *cloud.grid;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const int a = cell(grid, x, y);
      if (a < 0) continue;
      const int b = x + 1 < grid.width ? cell(grid, x + 1, y) : -1;
      const int c = y + 1 < grid.height ? cell(grid, x, y + 1) : -1;
      if (b >= 0) lengths.push_back(length(a, b));
      if (c >= 0) lengths.push_back(length(a, c));
    }
  }
  if (lengths.empty()) throw InvalidInput("scan: no two neighboring cells of its range grid hold points");
  median_edge_ = median(std::move(lengths));
}

double DepthJumps::length(int a, int b) const {
  const double length = (at(cloud_, a) - at(cloud_, b)).norm();
  if (!cloud_.scanner) return length;
  const double distance = std::min((at(cloud_, a) - *cloud_.scanner).norm(), (at(cloud_, b) - *cloud_.scanner).norm());
  return distance > 0.0 ? length / distance : length;
}

bool DepthJumps::operator()(int a, int b) const { return length(a, b) > kDepthJumpFactor * median_edge_; }

Mesh mesh_of_scan(const PointCloud& cloud) {
  if (cloud.triangles.empty() && !cloud.grid) {
    throw InvalidInput("a scan of " + std::to_string(cloud.points.size()) +
                       " points without faces or a range grid shows no surface; a grid or faces are needed");
  }
  Mesh mesh;
  mesh.positions = cloud.points;
  mesh.triangles = cloud.triangles;
  if (mesh.triangles.empty()) {
    mesh.triangles = grid_triangles(cloud);
    if (mesh.triangles.empty())
      throw InvalidInput("the scan's range grid gives no triangle: its points are too sparse");
    std::int64_t towards = 0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 normal = (at(cloud, t[1]) - at(cloud, t[0])).cross(at(cloud, t[2]) - at(cloud, t[0]));
      const std::optional<Vec3> to_scanner = direction_to_scanner(cloud, at(cloud, t[0]));
      if (to_scanner) towards += normal.dot(*to_scanner) >= 0.0 ? 1 : -1;
    }
    if (towards < 0) {
      for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    }
  }
  if (cloud.normals.size() == cloud.points.size()) {
    mesh.normals = cloud.normals;
    mesh.normal_triangles = mesh.triangles;
  }
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  mesh.surfaces.push_back({});
  return mesh;
}

}  // namespace patinate
