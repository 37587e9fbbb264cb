#include "patinate/geometry/crease_normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace patinate {

namespace {

/// Corners 3 t + k by which normal they share: each names one of its group.
class CornerGroups {
 public:
  explicit CornerGroups(std::size_t n) : same_(n) { std::iota(same_.begin(), same_.end(), std::size_t{0}); }
  [[nodiscard]] std::size_t root(std::size_t i) {
    while (same_[i] != i) i = same_[i] = same_[same_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t j) {
    const std::size_t a = root(i), b = root(j);
    same_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> same_;
};

std::vector<Vec3> unit_normals(const Mesh& mesh) {
  std::vector<Vec3> unit;
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const Vec3 area = area_vector(mesh, t);
    const double length = area.norm();
    unit.push_back(length > 0.0 ? Vec3(area / length) : Vec3(Vec3::Zero()));
  }
  return unit;
}

CornerGroups groups_of(const Mesh& mesh, const std::vector<Vec3>& unit, double least_cosine) {
  CornerGroups groups(3 * mesh.triangles.size());
  const std::vector<std::array<int, 3>> neighbors = triangle_neighbors(mesh);
  for (std::size_t t = 0; t < neighbors.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (neighbors[t][k] < 0) continue;
      const auto other = static_cast<std::size_t>(neighbors[t][k]);
      if (unit[t] != Vec3::Zero() && unit[other] != Vec3::Zero() && unit[t].dot(unit[other]) < least_cosine) continue;
      for (const std::size_t end : {k, (k + 1) % 3}) {
        for (std::size_t j = 0; j < 3; ++j) {
          if (mesh.triangles[other][j] == mesh.triangles[t][end]) groups.join(3 * t + end, 3 * other + j);
        }
      }
    }
  }
  return groups;
}

}  // namespace

Mesh with_crease_normals(Mesh mesh, double crease_deg) {
  if (!mesh.triangles.empty() && mesh.normal_triangles.size() == mesh.triangles.size()) return mesh;
  constexpr double kRounding = 1e-9;
  const double turn = std::clamp(crease_deg, 0.0, 180.0) * (std::numbers::pi / 180.0);
  const std::vector<Vec3> unit = unit_normals(mesh);
  CornerGroups groups = groups_of(mesh, unit, std::cos(turn) - kRounding);
  mesh.normals.clear();
  mesh.normal_triangles.assign(mesh.triangles.size(), Triangle{});
  std::vector<int> index(3 * mesh.triangles.size(), -1);
  for (std::size_t i = 0; i < index.size(); ++i) {
    const std::size_t t = i / 3, k = i % 3;
    int& normal = index[groups.root(i)];
    if (normal < 0) {
      normal = static_cast<int>(mesh.normals.size());
      mesh.normals.push_back(Vec3::Zero());
    }
    mesh.normal_triangles[t][k] = normal;
    const auto p = [&](std::size_t j) -> const Vec3& { return mesh.positions[mesh.triangles[t][j % 3]]; };
    const Vec3 a = p(k + 1) - p(k), b = p(k + 2) - p(k);
    mesh.normals[normal] += std::atan2(a.cross(b).norm(), a.dot(b)) * unit[t];
  }
  for (Vec3& normal : mesh.normals) {
    const double length = normal.norm();
    normal = length > 1e-12 ? Vec3(normal / length) : Vec3(Vec3::UnitZ());
  }
  return mesh;
}

}  // namespace patinate
