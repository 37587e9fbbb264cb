/// \file
/// Which texel centers lie in a triangle: the one rule by which surfaces become texels.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

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

/// Calls visit(x, y, b1, b2, inside) for every texel of a width x height grid whose center lies in the triangle `p`
/// (texel coordinates, either winding), row by row: barycentric weights of corners 1 and 2, and the least of all three
/// weights. before_row() is called now and then.
template <class Visit, class BeforeRow>
void for_each_texel(const std::array<Vec2, 3>& p, int width, int height, Visit&& visit, BeforeRow&& before_row) {
  const double area = cross2(p[1] - p[0], p[2] - p[0]);
  if (!(std::abs(area) > 0.0)) return;
  const auto low = [](double a, double b, double c, int most) {
    return static_cast<int>(std::clamp(std::ceil(std::min({a, b, c}) - 1e-6), 0.0, static_cast<double>(most)));
  };
  const auto high = [](double a, double b, double c, int most) {
    return static_cast<int>(std::clamp(std::floor(std::max({a, b, c}) + 1e-6), -1.0, most - 1.0));
  };
  const int x0 = low(p[0].x(), p[1].x(), p[2].x(), width), x1 = high(p[0].x(), p[1].x(), p[2].x(), width);
  const int y0 = low(p[0].y(), p[1].y(), p[2].y(), height), y1 = high(p[0].y(), p[1].y(), p[2].y(), height);
  for (int y = y0; y <= y1; ++y) {
    if (y % 256 == 255) before_row();
    for (int x = x0; x <= x1; ++x) {
      const auto [b1, b2] = weights_at(p, area, Vec2(x, y));
      const double inside = std::min({1.0 - b1 - b2, b1, b2});
      if (!(inside < -kInsideTolerance)) visit(x, y, b1, b2, inside);
    }
  }
}

}  // namespace patinate
