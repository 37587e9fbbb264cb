#include "libcommon/output/relief.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "libcommon/geometry/mesh_refine.h"
#include "libcommon/output/render_light.h"

namespace patinate {

namespace {

constexpr double kMinNormal = 0.2;  // Length of the mean of unit normals below which they point all ways.

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// For every position the first that is equal to it.
std::vector<int> first_equals(const std::vector<Vec3>& positions) {
  std::vector<int> order(positions.size());
  std::iota(order.begin(), order.end(), 0);
  const auto coordinates = [&](int i) {
    const Vec3& p = positions[index(i)];
    return std::array<double, 3>{p.x(), p.y(), p.z()};
  };
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return coordinates(a) != coordinates(b) ? coordinates(a) < coordinates(b) : a < b; });
  std::vector<int> first(positions.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool is_equal = k > 0 && coordinates(order[k]) == coordinates(order[k - 1]);
    first[index(order[k])] = is_equal ? first[index(order[k - 1])] : order[k];
  }
  return first;
}

// A corner as what it says of its position: the same UV and normal count once.
struct Corner {
  int position;
  int uv;
  int normal;
  auto operator<=>(const Corner&) const = default;
};

std::vector<Corner> distinct_corners(const Mesh& mesh) {
  std::vector<Corner> corners;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k)
      corners.push_back({mesh.triangles[t][k], mesh.uv_triangles[t][k], mesh.normal_triangles[t][k]});
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

void move_positions(Mesh& mesh, const ImageF& height, double factor) {
  struct Mean {
    Vec3 normal = Vec3::Zero();
    double height = 0.0;
    int count = 0;
  };
  std::vector<Mean> means(mesh.positions.size());
  for (const Corner& c : distinct_corners(mesh)) {
    Mean& mean = means[index(c.position)];
    const Vec2& uv = mesh.uvs[index(c.uv)];
    mean.normal += mesh.normals[index(c.normal)];
    mean.height += texture_at(height, uv.x(), uv.y())[0];
    ++mean.count;
  }
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Mean& mean = means[i];
    if (mean.count == 0 || mean.normal.norm() < kMinNormal * mean.count) continue;
    mesh.positions[i] += factor * mean.height / mean.count * mean.normal.normalized();
  }
}

// Normals of corners turned as the surface around them was.
void turn_normals(Mesh& mesh, const std::vector<Vec3>& before) {
  const std::vector<Vec3> after = vertex_normals(mesh);
  std::vector<Vec3> normals;
  normals.reserve(mesh.triangles.size() * 3);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t p = index(mesh.triangles[t][k]);
      const Vec3 turned = mesh.normals[index(mesh.normal_triangles[t][k])] + after[p] - before[p];
      normals.push_back(turned.norm() > 1e-6 ? Vec3(turned.normalized()) : after[p]);
      mesh.normal_triangles[t][k] = static_cast<int>(3 * t + k);
    }
  }
  mesh.normals = std::move(normals);
}

}  // namespace

double mean_texel_edge(const Mesh& mesh, const ImageF& map) {
  double area = 0.0, uv_area = 0.0;
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const Triangle& f = mesh.uv_triangles[index(t)];
    const Vec2 a = mesh.uvs[index(f[1])] - mesh.uvs[index(f[0])], b = mesh.uvs[index(f[2])] - mesh.uvs[index(f[0])];
    area += area_vector(mesh, t).norm();
    uv_area += std::abs(a.x() * b.y() - a.y() * b.x());
  }
  const double num_texels = uv_area * static_cast<double>(map.num_pixels());
  return num_texels > 0.0 ? std::sqrt(area / num_texels) : 0.0;
}

Mesh with_shared_positions(Mesh mesh) {
  const std::vector<int> first = first_equals(mesh.positions);
  for (Triangle& t : mesh.triangles) {
    for (int& i : t) i = first[index(i)];
  }
  return mesh;
}

Mesh refined_to_texels(Mesh mesh, const ImageF& map, int max_triangles, std::vector<float>& open) {
  const double texel = mean_texel_edge(mesh, map);
  if (!(texel > 0.0)) return mesh;
  std::vector<std::array<int, 2>> parents;
  mesh = refine_edges(std::move(mesh), std::numbers::sqrt2 * texel, max_triangles, RefineShape::Flat, parents);
  for (const auto& [a, b] : parents) open.push_back(0.5f * (open[index(a)] + open[index(b)]));
  return mesh;
}

Mesh displaced(Mesh mesh, const ImageF& height, double factor, ReliefNormals normals) {
  if (normals == ReliefNormals::Kept) {
    move_positions(mesh, height, factor);
    return mesh;
  }
  const std::vector<Vec3> before = vertex_normals(mesh);
  move_positions(mesh, height, factor);
  turn_normals(mesh, before);
  return mesh;
}

}  // namespace patinate
