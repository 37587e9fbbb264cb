/// How TexelMap finds out which triangle each texel shows: all at once, or square by square where one looks.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "libcommon/atlas/raster.h"
#include "patinate/atlas/texel_map.h"

namespace patinate {

namespace {

/// Of all texels, by how many each triangle has of its own size. @param sizes,counts  A triangle each.
double median_size(const std::vector<float>& sizes, const std::vector<std::int64_t>& counts, std::int64_t num_texels) {
  std::vector<std::size_t> order;
  for (std::size_t t = 0; t < counts.size(); ++t) {
    if (counts[t] > 0) order.push_back(t);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sizes[a] < sizes[b]; });
  std::int64_t seen = 0;
  for (std::size_t t : order) {
    seen += counts[t];
    if (seen > num_texels / 2) return static_cast<double>(sizes[t]);
  }
  return 0.0;
}

}  // namespace

struct TexelMap::Squares {
  static constexpr int kSide = 64;  ///< Texels.
  int columns = 0;
  std::vector<std::size_t> begin;       ///< By square, into `triangles`; one more at the end.
  std::vector<std::int32_t> triangles;  ///< Ascending in each square.
};

void TexelMap::search_all(const RunControl& control) {
  std::vector<std::int64_t> counts(mesh().triangles.size());
  for (int t = 0; t < mesh().num_triangles(); ++t) {
    if (t % 4096 == 0) control.throw_if_stopped();
    std::int64_t& count = counts[t];
    for_each_texel(
        corners_in_texels(t), rect(),
        [&](int x, int y, double, double, double inside) {
          std::int32_t& found = found_[TexelId{y} * width_ + x];
          if (found > 0) {
            if (inside > kOverlapTolerance) ++num_overlapping_;
            return;
          }
          found = t + 1;
          ++count;
        },
        [&] { control.throw_if_stopped(); });
  }
  count_is(counts);
}

/// Roots of the area of a texel in each triangle; 0 where that has none.
std::vector<float> TexelMap::texel_sizes() const {
  std::vector<float> sizes(mesh().triangles.size());
  for (int t = 0; t < mesh().num_triangles(); ++t) {
    const std::array<Vec2, 3> p = corners_in_texels(t);
    const double area = cross2(p[1] - p[0], p[2] - p[0]);
    if (!(std::abs(area) > 0.0)) continue;
    sizes[t] = static_cast<float>(std::sqrt(area_vector(mesh(), t).norm() / std::abs(area)));
  }
  return sizes;
}

void TexelMap::count_is(const std::vector<std::int64_t>& counts) {
  num_covered_ = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  median_texel_size_mm_ = median_size(texel_sizes(), counts, num_covered_);
}

double TexelMap::share_of_larger_texels(double size_mm) const {
  const std::vector<float> sizes = texel_sizes();
  double larger = 0.0, total = 0.0;
  for (int t = 0; t < mesh().num_triangles(); ++t) {
    const double area = area_vector(mesh(), t).norm();
    total += area;
    if (static_cast<double>(sizes[t]) > size_mm) larger += area;
  }
  return total > 0.0 ? larger / total : 0.0;
}

double TexelMap::median_texel_size_by_area_mm() const {
  const std::vector<float> sizes = texel_sizes();
  std::vector<std::pair<float, double>> areas;  // by the size of a texel
  double total = 0.0;
  for (int t = 0; t < mesh().num_triangles(); ++t) {
    const float size = sizes[t];
    if (!(size > 0.0f)) continue;
    areas.emplace_back(size, area_vector(mesh(), t).norm());
    total += areas.back().second;
  }
  std::sort(areas.begin(), areas.end());
  double below = 0.0;
  for (const auto& [size, area] : areas) {
    below += area;
    if (2.0 * below >= total) return static_cast<double>(size);
  }
  return 0.0;
}

std::vector<std::int64_t> TexelMap::count_texels(const TexelRect& part, const RunControl& control) const {
  std::vector<std::int64_t> counts(mesh().triangles.size());
  for (int y = part.y0; y < part.y1; ++y) {
    control.throw_if_stopped();
    for (int x = part.x0; x < part.x1; ++x) {
      if (const int t = triangle(TexelId{y} * width_ + x); t >= 0) ++counts[t];
    }
  }
  return counts;
}

std::vector<std::int32_t> TexelMap::triangles() const {
  std::vector<std::int32_t> all(static_cast<std::size_t>(num_texels()));
  for (TexelId t = 0; t < num_texels(); ++t) all[t] = triangle(t);
  return all;
}

void TexelMap::list_squares(const RunControl& control) {
  auto squares = std::make_shared<Squares>();
  squares->columns = (width_ + Squares::kSide - 1) / Squares::kSide;
  const int rows = (height_ + Squares::kSide - 1) / Squares::kSide;
  const auto for_each_square = [&](const auto& visit) {
    for (int t = 0; t < mesh().num_triangles(); ++t) {
      if (t % 4096 == 0) control.throw_if_stopped();
      const TexelRect box = texels_around(corners_in_texels(t), rect());
      for (int row = box.y0 / Squares::kSide; row * Squares::kSide < box.y1; ++row) {
        for (int column = box.x0 / Squares::kSide; column * Squares::kSide < box.x1; ++column)
          visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(squares->columns) +
                    static_cast<std::size_t>(column),
                t);
      }
    }
  };
  squares->begin.assign(static_cast<std::size_t>(squares->columns) * static_cast<std::size_t>(rows) + 1, 0);
  for_each_square([&](std::size_t square, int) { ++squares->begin[square + 1]; });
  std::partial_sum(squares->begin.begin(), squares->begin.end(), squares->begin.begin());
  squares->triangles.resize(squares->begin.back());
  std::vector<std::size_t> next(squares->begin.begin(), squares->begin.end() - 1);
  for_each_square([&](std::size_t square, int t) { squares->triangles[next[square]++] = t; });
  squares_ = std::move(squares);
}

int TexelMap::look_up(TexelId t) const {
  constexpr int kSide = Squares::kSide;
  const int column = static_cast<int>(t % width_) / kSide, row = static_cast<int>(t / width_) / kSide;
  const TexelRect square{column * kSide, row * kSide, std::min(width_, (column + 1) * kSide),
                         std::min(height_, (row + 1) * kSide)};
  std::array<std::int32_t, std::size_t{kSide} * kSide> found;
  found.fill(-1);
  const auto place = [&](int x, int y) -> std::int32_t& {
    return found[static_cast<std::size_t>(y - square.y0) * kSide + static_cast<std::size_t>(x - square.x0)];
  };
  const auto number =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(squares_->columns) + static_cast<std::size_t>(column);
  for (std::size_t i = squares_->begin[number]; i < squares_->begin[number + 1]; ++i) {
    const std::int32_t triangle = squares_->triangles[i];
    for_each_texel(
        corners_in_texels(triangle), square,
        [&](int x, int y, double, double, double) {
          if (place(x, y) < 0) place(x, y) = triangle + 1;
        },
        [] {});
  }
  for (int y = square.y0; y < square.y1; ++y) {
    for (int x = square.x0; x < square.x1; ++x)  // Other threads may write the same at once.
      __atomic_store_n(&found_[TexelId{y} * width_ + x], place(x, y), __ATOMIC_RELAXED);
  }
  return triangle(t);
}

}  // namespace patinate
