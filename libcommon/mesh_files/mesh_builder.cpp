#include "libcommon/mesh_files/mesh_builder.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxTriangles = 100'000'000;
constexpr std::size_t kMaxCorners = 4096;  // ear clipping takes quadratic time, or worse

std::uint64_t bits(double value) { return std::bit_cast<std::uint64_t>(value + 0.0); }  // -0 becomes 0

/// The two axes to keep so that a polygon with this area vector stays counter-clockwise.
std::pair<int, int> projection_axes(const Vec3& area) {
  int dropped = 0;
  area.cwiseAbs().maxCoeff(&dropped);
  int u = (dropped + 1) % 3, v = (dropped + 2) % 3;
  if (area[dropped] < 0.0) std::swap(u, v);
  return {u, v};
}

double cross(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Whether corner `k` of the remaining loop can be cut off: it is convex and no other corner lies in its triangle.
bool is_ear(const std::vector<Vec2>& points, const std::vector<int>& loop, std::size_t k) {
  const auto at = [&](std::size_t i) -> const Vec2& { return points[loop[i % loop.size()]]; };
  const Vec2 &a = at(k + loop.size() - 1), &b = at(k), &c = at(k + 1);
  if (!(cross(a, b, c) > 0.0)) return false;
  for (std::size_t i = k + 2; i < k + loop.size() - 1; ++i) {
    const Vec2& p = at(i);
    if (p == a || p == b || p == c) continue;
    if (cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0) return false;
  }
  return true;
}

}  // namespace

std::vector<Triangle> triangulate_polygon(std::span<const Vec3> corners) {
  std::vector<Triangle> triangles;
  const int n = static_cast<int>(corners.size());
  if (n == 3) return {{0, 1, 2}};
  Vec3 area = Vec3::Zero();
  for (int i = 1; i + 1 < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    area += (corners[k] - corners[0]).cross(corners[k + 1] - corners[0]);
  }
  const auto [u, v] = projection_axes(area);
  std::vector<Vec2> points;
  for (const Vec3& p : corners) points.emplace_back(p[u], p[v]);
  std::vector<int> loop(corners.size());
  std::iota(loop.begin(), loop.end(), 0);
  bool is_simple = true;
  std::size_t k = 1, tried = 0;
  while (loop.size() > 3) {
    if (k >= loop.size()) k = 0;
    if (is_simple && !is_ear(points, loop, k)) {
      ++k;
      is_simple = ++tried < loop.size();
      continue;
    }
    const std::size_t m = loop.size();
    triangles.push_back({loop[(k + m - 1) % m], loop[k], loop[(k + 1) % m]});
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(k));
    tried = 0;
  }
  if (loop.size() == 3) triangles.push_back({loop[0], loop[1], loop[2]});
  return triangles;
}

std::size_t MeshBuilder::KeyHash::operator()(const Key& key) const {
  std::uint64_t h = 0x9e3779b97f4a7c15ull;
  for (std::uint64_t part : key) {
    h ^= part + 0x9e3779b97f4a7c15ull;
    h *= 0xbf58476d1ce4e5b9ull;
    h ^= h >> 29;
  }
  return static_cast<std::size_t>(h);
}

void MeshBuilder::set_surface(const std::string& node, const std::string& material) {
  node_ = nodes_.try_emplace(node, static_cast<int>(nodes_.size())).first->second;
  const auto [entry, is_new] = surfaces_.try_emplace(node + '\0' + material, static_cast<int>(mesh_.surfaces.size()));
  if (is_new) mesh_.surfaces.push_back({node, material});
  surface_ = entry->second;
}

int MeshBuilder::position_index(const Vec3& p) {
  const Key key{static_cast<std::uint64_t>(node_), bits(p.x()), bits(p.y()), bits(p.z())};
  const auto [entry, is_new] = positions_.try_emplace(key, static_cast<int>(mesh_.positions.size()));
  if (is_new) mesh_.positions.push_back(p);
  return entry->second;
}

int MeshBuilder::uv_index(int position, const Vec2& uv) {
  const Key key{static_cast<std::uint64_t>(position), bits(uv.x()), bits(uv.y()), 0};
  const auto [entry, is_new] = uvs_.try_emplace(key, static_cast<int>(mesh_.uvs.size()));
  if (is_new) mesh_.uvs.push_back(uv);
  return entry->second;
}

int MeshBuilder::normal_index(const Vec3& normal) {
  const double length = normal.norm();
  if (!(length > 0.0)) return -1;
  const Vec3 n = normal / length;
  const auto [entry, is_new] =
      normals_.try_emplace(Key{bits(n.x()), bits(n.y()), bits(n.z()), 0}, static_cast<int>(mesh_.normals.size()));
  if (is_new) mesh_.normals.push_back(n);
  return entry->second;
}

void MeshBuilder::check_finite(const Corner& corner) const {
  // Products of three coordinates must stay finite too.
  if (!corner.position.allFinite() || corner.position.cwiseAbs().maxCoeff() > 1e30) {
    throw IoError(file_, "a position is not finite or beyond 1e30; NaN and infinity are not allowed");
  }
  if (corner.uv && !corner.uv->allFinite())
    throw IoError(file_, "a UV is not finite; NaN and infinity are not allowed");
  if (corner.normal && !corner.normal->allFinite()) {
    throw IoError(file_, "a normal is not finite; NaN and infinity are not allowed");
  }
}

void MeshBuilder::add_polygon(std::span<const Corner> corners) {
  if (corners.size() < 3) return;
  if (corners.size() > kMaxCorners) {
    throw IoError(file_,
                  "a face has " + std::to_string(corners.size()) + " corners; at most " + std::to_string(kMaxCorners));
  }
  if (mesh_.triangles.size() + corners.size() > kMaxTriangles) {
    throw IoError(file_, "more than " + std::to_string(kMaxTriangles) + " triangles");
  }
  if (surface_ < 0) set_surface("", "");
  std::vector<Vec3> points;
  for (const Corner& corner : corners) {
    check_finite(corner);
    points.push_back(corner.position);
  }
  for (const Triangle& t : triangulate_polygon(points)) {
    Triangle position{}, uv{}, normal{};
    for (std::size_t k = 0; k < 3; ++k) position[k] = position_index(points[t[k]]);
    if (position[0] == position[1] || position[1] == position[2] || position[2] == position[0]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner& corner = corners[t[k]];
      has_uv_ = has_uv_ || corner.uv;
      uv[k] = corner.uv ? uv_index(position[k], *corner.uv) : -1;
      normal[k] = corner.normal ? normal_index(*corner.normal) : -1;
    }
    mesh_.triangles.push_back(position);
    mesh_.uv_triangles.push_back(uv);
    mesh_.normal_triangles.push_back(normal);
    mesh_.triangle_surface.push_back(surface_);
  }
}

void MeshBuilder::fill_missing_normals() {
  std::vector<Vec3> smooth;
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      int& index = mesh_.normal_triangles[t][k];
      if (index >= 0) continue;
      if (smooth.empty()) smooth = vertex_normals(mesh_);
      index = normal_index(smooth[mesh_.triangles[t][k]]);
    }
  }
}

Mesh MeshBuilder::finish() {
  if (mesh_.triangles.empty()) throw IoError(file_, "no triangle with three different corners; a surface is needed");
  if (!has_uv_) mesh_.uv_triangles.clear();
  if (mesh_.normals.empty()) {
    mesh_.normal_triangles.clear();
  } else {
    fill_missing_normals();
  }
  // Only what is in use: degenerate polygons may have left positions and surfaces behind.
  return select_surfaces(mesh_, "", "");
}

}  // namespace patinate
