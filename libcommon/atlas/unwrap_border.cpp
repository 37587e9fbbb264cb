#include "libcommon/atlas/unwrap_border.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace patinate {

namespace {

double side(const Vec2& a, const Vec2& b, const Vec2& p) {
  return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
}

bool cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  if (std::max(a.x(), b.x()) < std::min(c.x(), d.x()) || std::max(c.x(), d.x()) < std::min(a.x(), b.x()) ||
      std::max(a.y(), b.y()) < std::min(c.y(), d.y()) || std::max(c.y(), d.y()) < std::min(a.y(), b.y())) {
    return false;
  }
  const double c_side = side(a, b, c), d_side = side(a, b, d), a_side = side(c, d, a), b_side = side(c, d, b);
  return !(c_side > 0.0 && d_side > 0.0) && !(c_side < 0.0 && d_side < 0.0) && !(a_side > 0.0 && b_side > 0.0) &&
         !(a_side < 0.0 && b_side < 0.0);
}

/// Square cells about as wide as a segment is long, at most some 4 million.
struct Grid {
  Vec2 low;
  double cell = 1.0;
  std::int64_t width = 1;

  Grid(const std::vector<Vec2>& points, const std::vector<std::array<int, 2>>& segments) {
    low = points[segments[0][0]];
    Vec2 high = low;
    double length = 0.0;
    for (const auto& [a, b] : segments) {
      const Vec2 &p = points[a], &q = points[b];
      low = low.cwiseMin(p).cwiseMin(q);
      high = high.cwiseMax(p).cwiseMax(q);
      length += (q - p).norm();
    }
    const double size = (high - low).maxCoeff();
    cell = std::max({length / static_cast<double>(segments.size()), size / 2000.0, 1e-300});
    width = static_cast<std::int64_t>(size / cell) + 1;
  }
  [[nodiscard]] std::int64_t index(double x, double origin) const {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>((x - origin) / cell), 0, width - 1);
  }
};

}  // namespace

bool borders_cross(const std::vector<Vec2>& points, const std::vector<std::array<int, 2>>& segments) {
  if (segments.size() < 2) return false;
  const Grid grid(points, segments);
  std::vector<std::pair<std::int64_t, std::int32_t>> entries;  // (cell, segment)
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Vec2 &p = points[segments[i][0]], &q = points[segments[i][1]];
    const std::int64_t y1 = grid.index(std::max(p.y(), q.y()), grid.low.y()),
                       x1 = grid.index(std::max(p.x(), q.x()), grid.low.x());
    for (std::int64_t y = grid.index(std::min(p.y(), q.y()), grid.low.y()); y <= y1; ++y) {
      for (std::int64_t x = grid.index(std::min(p.x(), q.x()), grid.low.x()); x <= x1; ++x) {
        entries.emplace_back(y * grid.width + x, static_cast<std::int32_t>(i));
      }
    }
  }
  std::sort(entries.begin(), entries.end());
  for (std::size_t begin = 0; begin < entries.size();) {
    std::size_t end = begin + 1;
    while (end < entries.size() && entries[end].first == entries[begin].first) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = i + 1; j < end; ++j) {
        const auto& [a, b] = segments[entries[i].second];
        const auto& [c, d] = segments[entries[j].second];
        if (a == c || a == d || b == c || b == d) continue;
        if (cross(points[a], points[b], points[c], points[d])) {
          return true;
        }
      }
    }
    begin = end;
  }
  return false;
}

}  // namespace patinate
