#include "simulation/tracing/surface_links.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace patinate::simulation {

namespace {

/// Indices of positions, one for all that are equal and belong to one object.
std::vector<int> welded_positions(const SceneMesh& scene_mesh) {
  const Mesh& mesh = scene_mesh.mesh;
  std::vector<int> object(mesh.positions.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const int p : mesh.triangles[t]) object[p] = scene_mesh.object[t];
  }
  const auto key = [&](int i) {
    const Vec3& p = mesh.positions[i];
    return std::tuple(object[i], p.x(), p.y(), p.z());
  };
  std::vector<int> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const auto ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  std::vector<int> welded(mesh.positions.size());
  int first = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || key(order[i]) != key(first)) first = order[i];
    welded[order[i]] = first;
  }
  return welded;
}

}  // namespace

SurfaceLinks::SurfaceLinks(const SceneMesh& scene_mesh) {
  const std::vector<int> welded = welded_positions(scene_mesh);
  Mesh mesh;
  mesh.positions = scene_mesh.mesh.positions;
  mesh.triangles = scene_mesh.mesh.triangles;
  for (Triangle& t : mesh.triangles) {
    for (int& p : t) p = welded[p];
  }
  const std::vector<std::array<int, 3>> neighbors = triangle_neighbors(mesh);
  constexpr std::uint32_t kNone = motion_types::kNoLink;
  codes_.assign(neighbors.size(), TriangleLinks{.across = {kNone, kNone, kNone}});
  for (std::size_t t = 0; t < neighbors.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (neighbors[t][k] < 0) continue;
      const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      const Triangle& there = mesh.triangles[neighbors[t][k]];
      for (std::uint32_t j = 0; j < 3; ++j) {
        const int c = there[j], d = there[(j + 1) % 3];
        if (!((a == d && b == c) || (a == c && b == d))) continue;
        codes_[t].across[k] = static_cast<std::uint32_t>(neighbors[t][k]) << 3 | j << 1 | (a == c ? 1u : 0u);
        break;
      }
    }
  }
}

}  // namespace patinate::simulation
