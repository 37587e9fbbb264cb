// Area weights of texels: the surface that texel_of() gives to each, so that even rain wets texels at a chart's edge,
// of which the chart may own half a cell or one and a half, as it does those inside.
#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/atlas/places.h"

namespace patinate::simulation {

namespace {

constexpr int kSearchRadius = place_types::kSearchRadius;

constexpr double kFraction = 1024.0;  // sums are in parts of a weight's unit, so that their order does not matter
constexpr std::uint32_t kEnough = 1u << 31;  // beyond this a sum ends at kMaxWeight anyway
constexpr int kSamples = 16;                 // along a cell's side, where its own texel is not of the chart

/// A convex polygon: a triangle cut by the four sides of a cell.
struct Polygon {
  std::array<Vec2, 8> corners;
  std::size_t size = 0;
  void add(const Vec2& p) { corners[size++] = p; }
  [[nodiscard]] double area() const {
    double twice = 0.0;
    for (std::size_t i = 0; i < size; ++i) {
      const Vec2& a = corners[i];
      const Vec2& b = corners[(i + 1) % size];
      twice += a.x() * b.y() - a.y() * b.x();
    }
    return 0.5 * std::abs(twice);
  }
};

/// The part with sign * p[axis] <= sign * limit [Sutherland and Hodgman 1974].
Polygon cut(const Polygon& from, int axis, double sign, double limit) {
  Polygon out;
  for (std::size_t i = 0; i < from.size; ++i) {
    const Vec2& a = from.corners[i];
    const Vec2& b = from.corners[(i + 1) % from.size];
    const double da = sign * (a[axis] - limit), db = sign * (b[axis] - limit);
    if (da <= 0.0) out.add(a);
    if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) out.add(a + (b - a) * (da / (da - db)));
  }
  return out;
}

/// Where the horizontal line at y meets the triangle; empty (lo > hi) where it does not.
std::array<double, 2> span_at(const Polygon& triangle, double y) {
  double lo = 1e30, hi = -1e30;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2& a = triangle.corners[i];
    const Vec2& b = triangle.corners[(i + 1) % 3];
    if ((a.y() > y && b.y() > y) || (a.y() < y && b.y() < y)) continue;
    if (a.y() == b.y()) {
      lo = std::min({lo, a.x(), b.x()});
      hi = std::max({hi, a.x(), b.x()});
      continue;
    }
    const double x = a.x() + (b.x() - a.x()) * ((y - a.y()) / (b.y() - a.y()));
    lo = std::min(lo, x);
    hi = std::max(hi, x);
  }
  return {lo, hi};
}

int cell_of(double coordinate, int size) {
  return std::clamp(static_cast<int>(std::floor(coordinate + 0.5)), 0, size - 1);
}

}  // namespace

void SurfaceAtlas::weigh_texels(std::span<const double> weight_per_texel, const RunControl& control) {
  std::vector<std::uint32_t> sums(triangle_.size(), 0);
  const auto give = [&](TexelIndex texel, double weight) {
    if (texel == kNoTexel) return;
    const std::atomic_ref<std::uint32_t> sum(sums[texel]);
    if (sum.load(std::memory_order_relaxed) > kEnough) return;
    sum.fetch_add(static_cast<std::uint32_t>(std::lround(kFraction * std::min<double>(weight, kMaxWeight))),
                  std::memory_order_relaxed);
  };
  const auto weigh = [&](int triangle) {
    const auto t = static_cast<std::size_t>(triangle);
    const double per_texel = weight_per_texel[t];
    Polygon corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners.add({static_cast<double>(corner_texels_[t][2 * k]), static_cast<double>(corner_texels_[t][2 * k + 1])});
    const auto [min_y, max_y] = std::minmax({corners.corners[0].y(), corners.corners[1].y(), corners.corners[2].y()});
    // A cell of which this is all that the triangle has.
    const auto give_part = [&](int x, int y, const Polygon& part) {
      const double area = part.area();
      if (!(area > 0.0)) return;
      if (shows_chart_of(grid_.index(x, y), triangle)) return give(grid_.index(x, y), per_texel * area);
      // No texel of the chart is here: each place goes to the nearest one, as nearest_texel() has it.
      std::array<TexelIndex, (2 * kSearchRadius + 1) * (2 * kSearchRadius + 1)> near;
      std::array<int, near.size()> samples{};
      std::size_t num_near = 0;
      for (int ny = std::max(0, y - kSearchRadius); ny <= std::min(grid_.height - 1, y + kSearchRadius); ++ny) {
        for (int nx = std::max(0, x - kSearchRadius); nx <= std::min(grid_.width - 1, x + kSearchRadius); ++nx) {
          if (shows_chart_of(grid_.index(nx, ny), triangle)) near[num_near++] = grid_.index(nx, ny);
        }
      }
      if (num_near == 0) return give(fallback_[t], per_texel * area);
      int count = 0;
      for (int j = 0; j < kSamples; ++j) {
        const double py = y - 0.5 + (j + 0.5) / kSamples;
        const std::array<double, 2> inside = span_at(corners, py);
        for (int i = 0; i < kSamples; ++i) {
          const double px = x - 0.5 + (i + 0.5) / kSamples;
          if (px < inside[0] || px > inside[1]) continue;
          const auto distance = [&](TexelIndex n) {
            return (grid_.x(n) - px) * (grid_.x(n) - px) + (grid_.y(n) - py) * (grid_.y(n) - py);
          };
          std::size_t best = 0;
          for (std::size_t n = 1; n < num_near; ++n) {
            if (distance(near[n]) < distance(near[best])) best = n;
          }
          ++samples[best];
          ++count;
        }
      }
      if (count == 0) {  // less than a sample
        const Vec2& somewhere = part.corners[0];
        return give(nearest_texel(triangle, somewhere.x(), somewhere.y()), per_texel * area);
      }
      for (std::size_t n = 0; n < num_near; ++n) {
        if (samples[n] > 0) give(near[n], per_texel * area * samples[n] / count);
      }
    };
    for (int y = cell_of(min_y, grid_.height); y <= cell_of(max_y, grid_.height); ++y) {
      const Polygon row = cut(cut(corners, 1, -1.0, y - 0.5), 1, 1.0, y + 0.5);
      if (row.size < 3) continue;
      double min_x = row.corners[0].x(), max_x = min_x;
      for (std::size_t k = 1; k < row.size; ++k) {
        min_x = std::min(min_x, row.corners[k].x());
        max_x = std::max(max_x, row.corners[k].x());
      }
      const std::array<double, 2> above = span_at(corners, y - 0.5), below = span_at(corners, y + 0.5);
      const double whole_from = std::max(above[0], below[0]), whole_to = std::min(above[1], below[1]);
      for (int x = cell_of(min_x, grid_.width); x <= cell_of(max_x, grid_.width); ++x) {
        if (x - 0.5 >= whole_from && x + 0.5 <= whole_to && shows_chart_of(grid_.index(x, y), triangle))
          give(grid_.index(x, y), per_texel);
        else
          give_part(x, y, cut(cut(row, 0, -1.0, x - 0.5), 0, 1.0, x + 0.5));
      }
    }
  };
  parallel_for(static_cast<std::int64_t>(weight_.size()), 256, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<int>(begin); i < static_cast<int>(end); ++i) weigh(i);
  });
  texel_weight_.resize(triangle_.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    texel_weight_[i] = static_cast<std::uint16_t>(std::clamp<double>(std::round(sums[i] / kFraction), 1.0, kMaxWeight));
  }
}

}  // namespace patinate::simulation
