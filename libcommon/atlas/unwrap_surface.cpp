#include "libcommon/atlas/unwrap_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr double kFlattest = 1e-4;  ///< Height over longest side below which a triangle is given that height.
constexpr double kNoNormal = 1e-6;  ///< Height over longest side below which rounding decides where a triangle faces.
constexpr double kSmallest = 1e-9;  ///< Longest side, at unit area, below which a triangle is taken to be this large.
constexpr double kNoArea = 1e-14;   ///< Share of a connected piece, at unit area.

bool has_repeated_corner(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

void scale_to_unit_area(UnwrapSurface& s) {
  Vec3 low = s.positions[s.triangles[0][0]], high = low;
  for (const Triangle& t : s.triangles) {
    for (int i : t) {
      const Vec3& p = s.positions[i];
      if (!p.allFinite()) throw InvalidInput("the mesh cannot be unwrapped: a position is not finite");
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  const double size = (high - low).maxCoeff();
  if (!(size > 0.0) || !std::isfinite(size)) throw InvalidInput("the mesh cannot be unwrapped: it has no area");
  for (Vec3& p : s.positions)
    p = (p - 0.5 * (low + high)) / size;  // First, so that squares neither vanish nor overflow.
  double total = 0.0;
  for (const Triangle& t : s.triangles) {
    const auto at = [&](std::size_t k) -> const Vec3& { return s.positions[t[k]]; };
    total += 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
  }
  if (!(total > kNoArea)) throw InvalidInput("the mesh cannot be unwrapped: it has no area");
  const double scale = 1.0 / std::sqrt(total);
  for (Vec3& p : s.positions) p *= scale;
  s.area = total * size * size;
}

/// Only neighbors that run through the shared edge the other way, and no triangle that is none.
void keep_oriented_neighbors(UnwrapSurface& s) {
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      int& n = s.neighbors[t][k];
      if (n < 0) continue;
      const Triangle& other = s.triangles[n];
      const std::size_t b = corner_of(other, s.triangles[t][(k + 1) % 3]);
      const bool agrees = !has_repeated_corner(s.triangles[t]) && !has_repeated_corner(other) &&
                          other[(b + 1) % 3] == s.triangles[t][k];
      if (!agrees) n = -1;
    }
  }
}

/// Triangles that rounding has turned anywhere face as those around them do.
void borrow_normals(UnwrapSurface& s, std::vector<int> without) {
  std::vector<bool> has_normal(s.triangles.size(), true);
  for (int t : without) has_normal[t] = false;
  while (!without.empty()) {
    std::vector<std::pair<int, Vec3>> found;
    std::vector<int> rest;
    for (int t : without) {
      Vec3 sum = Vec3::Zero();
      for (int n : s.neighbors[t]) {
        if (n >= 0 && has_normal[n]) sum += s.normals[n];
      }
      if (sum.norm() > 1e-6) {
        found.emplace_back(t, sum.normalized());
      } else {
        rest.push_back(t);
      }
    }
    if (found.empty()) return;
    for (const auto& [t, normal] : found) {
      s.normals[t] = normal;
      has_normal[t] = true;
    }
    without = std::move(rest);
  }
}

void mark_pieces_without_area(UnwrapSurface& s) {
  std::vector<int> all(s.triangles.size());
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = static_cast<int>(t);
  for (const std::vector<int>& piece : connected_parts(s, all, std::vector<int>(s.triangles.size(), 0))) {
    double area = 0.0;
    for (int t : piece) area += s.areas[t];
    if (area > kNoArea) continue;
    for (int t : piece) s.is_point[t] = true;
  }
}

}  // namespace

std::size_t corner_of(const Triangle& triangle, int position) {
  std::size_t k = 0;
  while (k < 2 && triangle[k] != position) ++k;
  return k;
}

bool UnwrapSurface::has_shape(int triangle) const {
  const Triangle& t = triangles[triangle];
  const auto at = [&](std::size_t k) -> const Vec3& { return positions[t[k]]; };
  const double longest2 =
      std::max({(at(1) - at(0)).squaredNorm(), (at(2) - at(1)).squaredNorm(), (at(0) - at(2)).squaredNorm()});
  return !is_point[triangle] && longest2 > kSmallest * kSmallest && 2.0 * areas[triangle] > kFlattest * longest2;
}

std::array<Vec2, 3> UnwrapSurface::flat(int triangle) const {
  const Triangle& t = triangles[triangle];
  const auto at = [&](std::size_t k) -> const Vec3& { return positions[t[k]]; };
  const double a = (at(1) - at(0)).norm(), b = (at(2) - at(1)).norm(), c = (at(0) - at(2)).norm();
  const double longest = std::max({a, b, c});
  const double twice_area = 2.0 * areas[triangle];
  if (!(longest > kSmallest)) return {Vec2(0.0, 0.0), Vec2(kSmallest, 0.0), Vec2(0.5 * kSmallest, 0.8 * kSmallest)};
  const double height = std::max(twice_area / longest, kFlattest * longest);
  // Corner k0 and k0 + 1 end the longest side; the foot of the third lies between them.
  const std::size_t k0 = a == longest ? 0 : (b == longest ? 1 : 2);
  const double foot = std::clamp((at((k0 + 2) % 3) - at(k0)).dot(at((k0 + 1) % 3) - at(k0)) / longest, 0.0, longest);
  std::array<Vec2, 3> p;
  p[k0] = Vec2(0.0, 0.0);
  p[(k0 + 1) % 3] = Vec2(longest, 0.0);
  p[(k0 + 2) % 3] = Vec2(foot, height);
  return p;
}

std::vector<std::vector<int>> connected_parts(const UnwrapSurface& surface, const std::vector<int>& triangles,
                                              const std::vector<int>& part_of) {
  std::vector<int> sorted = triangles;
  std::sort(sorted.begin(), sorted.end());
  std::vector<bool> is_seen(sorted.size(), false);
  std::vector<std::vector<int>> parts;
  std::vector<int> open;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (is_seen[i]) continue;
    is_seen[i] = true;
    open.assign(1, sorted[i]);
    std::vector<int> part;
    while (!open.empty()) {
      const int t = open.back();
      open.pop_back();
      part.push_back(t);
      for (int n : surface.neighbors[t]) {
        if (n < 0 || part_of[n] != part_of[t]) continue;
        const auto it = std::lower_bound(sorted.begin(), sorted.end(), n);
        if (it == sorted.end() || *it != n) continue;
        const auto j = static_cast<std::size_t>(it - sorted.begin());
        if (is_seen[j]) continue;
        is_seen[j] = true;
        open.push_back(n);
      }
    }
    std::sort(part.begin(), part.end());
    parts.push_back(std::move(part));
  }
  return parts;
}

UnwrapSurface make_unwrap_surface(const Mesh& mesh) {
  if (mesh.triangles.empty()) throw InvalidInput("the mesh cannot be unwrapped: it has no triangles");
  UnwrapSurface s;
  s.positions = mesh.positions;
  s.triangles = mesh.triangles;
  s.neighbors = triangle_neighbors(mesh);
  scale_to_unit_area(s);
  keep_oriented_neighbors(s);
  const std::size_t n = s.triangles.size();
  s.normals.assign(n, Vec3::UnitZ());
  s.centroids.resize(n);
  s.areas.resize(n);
  s.is_point.assign(n, false);
  std::vector<int> without_normal;
  for (std::size_t t = 0; t < n; ++t) {
    const auto at = [&](std::size_t k) -> const Vec3& { return s.positions[s.triangles[t][k]]; };
    const Vec3 e1 = at(1) - at(0), e2 = at(2) - at(0), normal = e1.cross(e2);
    const double length = normal.norm();
    const double longest2 = std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()});
    s.areas[t] = 0.5 * length;
    s.centroids[t] = (at(0) + at(1) + at(2)) / 3.0;
    s.is_point[t] = has_repeated_corner(s.triangles[t]);
    if (length > kNoNormal * longest2) {
      s.normals[t] = normal / length;
    } else {
      without_normal.push_back(static_cast<int>(t));
    }
  }
  borrow_normals(s, std::move(without_normal));
  mark_pieces_without_area(s);
  return s;
}

}  // namespace patinate
