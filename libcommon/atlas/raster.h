/// \file
/// Which texel centers lie in a triangle: the one rule by which surfaces become texels.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "patinate/atlas/texel_map.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

inline constexpr double kInsideTolerance = 1e-9;   ///< Barycentric; centers on an edge belong to both triangles.
inline constexpr double kOverlapTolerance = 1e-6;  ///< Deeper inside than this is an overlap, not a shared edge.

/// Texel coordinates (x right, y down, centers at integers) of a UV.
[[nodiscard]] inline Vec2 texel_from_uv(const Vec2& uv, int width, int height) {
  return {uv.x() * width - 0.5, (1.0 - uv.y()) * height - 0.5};
}

[[nodiscard]] inline double cross2(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Barycentric weights of corners 1 and 2 of the triangle `p` at a point. @param area  cross2() of its sides from
/// corner 0, not 0.
[[nodiscard]] inline std::array<double, 2> weights_at(const std::array<Vec2, 3>& p, double area, const Vec2& q) {
  return {cross2(q - p[0], p[2] - p[0]) / area, cross2(p[1] - p[0], q - p[0]) / area};
}

/// The texels of `part` that may lie in a triangle (texel coordinates).
[[nodiscard]] inline TexelRect texels_around(const std::array<Vec2, 3>& p, const TexelRect& part) {
  const auto low = [](double a, double b, double c, int from, int to) {
    return static_cast<int>(
        std::clamp(std::ceil(std::min({a, b, c}) - 1e-6), static_cast<double>(from), static_cast<double>(to)));
  };
  const auto high = [](double a, double b, double c, int from, int to) {
    return 1 + static_cast<int>(std::clamp(std::floor(std::max({a, b, c}) + 1e-6), from - 1.0, to - 1.0));
  };
  return {low(p[0].x(), p[1].x(), p[2].x(), part.x0, part.x1), low(p[0].y(), p[1].y(), p[2].y(), part.y0, part.y1),
          high(p[0].x(), p[1].x(), p[2].x(), part.x0, part.x1), high(p[0].y(), p[1].y(), p[2].y(), part.y0, part.y1)};
}

/// Calls visit(x, y, b1, b2, inside) for every texel of `part` whose center lies in the triangle `p` (texel
/// coordinates, either winding), row by row: barycentric weights of corners 1 and 2, and the least of all three
/// weights. before_row() is called now and then.
template <class Visit, class BeforeRow>
void for_each_texel(const std::array<Vec2, 3>& p, const TexelRect& part, Visit&& visit, BeforeRow&& before_row) {
  const double area = cross2(p[1] - p[0], p[2] - p[0]);
  if (!(std::abs(area) > 0.0)) return;
  const TexelRect box = texels_around(p, part);
  for (int y = box.y0; y < box.y1; ++y) {
    if (y % 256 == 255) before_row();
    for (int x = box.x0; x < box.x1; ++x) {
      const auto [b1, b2] = weights_at(p, area, Vec2(x, y));
      const double inside = std::min({1.0 - b1 - b2, b1, b2});
      if (!(inside < -kInsideTolerance)) visit(x, y, b1, b2, inside);
    }
  }
}

}  // namespace patinate
