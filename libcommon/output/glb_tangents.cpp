#include "libcommon/output/glb_tangents.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace patinate {

namespace {

Vec3 corner_normal(const Mesh& mesh, std::size_t t, std::size_t k) {
  return mesh.normals[mesh.normal_triangles[t][k]].normalized();
}

/// `v` without what lies along `normal`, unit; any direction across it where nothing is left.
Vec3 across(const Vec3& v, const Vec3& normal) {
  const Vec3 flat = v - v.dot(normal) * normal;
  const double length = flat.norm();
  return length > 1e-12 ? Vec3(flat / length) : Vec3(normal.unitOrthogonal());
}

}  // namespace

namespace {

/// Sums over the corners that share position, UV, normal and the side of the UVs. A position has few of them: a list.
class CornerSums {
 public:
  explicit CornerSums(const Mesh& mesh) : mesh_(mesh), first_(mesh.positions.size(), -1) {}
  Vec3& at(std::size_t t, std::size_t k, bool is_mirrored) {
    const int uv = mesh_.uv_triangles[t][k], normal = mesh_.normal_triangles[t][k];
    int& first = first_[mesh_.triangles[t][k]];
    for (int i = first; i >= 0; i = sums_[i].next) {
      if (sums_[i].uv == uv && sums_[i].normal == normal && sums_[i].is_mirrored == is_mirrored) return sums_[i].value;
    }
    sums_.push_back({uv, normal, is_mirrored, first});
    first = static_cast<int>(sums_.size()) - 1;
    return sums_.back().value;
  }

 private:
  struct Sum {
    int uv, normal;
    bool is_mirrored;
    int next;  ///< Another of the same position; -1: the last.
    Vec3 value = Vec3::Zero();
  };
  const Mesh& mesh_;
  std::vector<int> first_;  ///< A position's latest sum; -1: none.
  std::vector<Sum> sums_;
};

}  // namespace

CornerTangents corner_tangents(const Mesh& mesh) {
  const std::size_t n = mesh.triangles.size();
  CornerTangents result{.tangent = std::vector<std::array<Vec3, 3>>(n), .is_mirrored = std::vector<bool>(n)};
  CornerSums sums(mesh);
  for (std::size_t t = 0; t < n; ++t) {
    std::array<Vec3, 3> p;
    std::array<Vec2, 3> uv;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = mesh.positions[mesh.triangles[t][k]];
      uv[k] = mesh.uvs[mesh.uv_triangles[t][k]];
    }
    const Vec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    const double area = a.x() * b.y() - a.y() * b.x();
    result.is_mirrored[t] = area < 0.0;
    const Vec3 along_u = ((p[1] - p[0]) * b.y() - (p[2] - p[0]) * a.y()) * (area < 0.0 ? -1.0 : 1.0);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 to_next = p[(k + 1) % 3] - p[k], to_last = p[(k + 2) % 3] - p[k];
      const double angle = std::atan2(to_next.cross(to_last).norm(), to_next.dot(to_last));
      Vec3& sum = sums.at(t, k, result.is_mirrored[t]);
      if (along_u.squaredNorm() > 0.0) sum += angle * across(along_u, corner_normal(mesh, t, k));
    }
  }
  for (std::size_t t = 0; t < n; ++t) {
    for (std::size_t k = 0; k < 3; ++k)
      result.tangent[t][k] = across(sums.at(t, k, result.is_mirrored[t]), corner_normal(mesh, t, k));
  }
  return result;
}

}  // namespace patinate
