// Triangle that each texel of a TexelMap shows, and the size of texels.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "libcommon/atlas/raster.h"
#include "patinate/atlas/texel_map.h"

namespace patinate {

namespace {

/// Median size of all texels, by how many each triangle has of its own size. @param sizes,counts  A triangle each.
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

void TexelMap::find_triangles(const RunControl& control) {
  std::vector<std::int64_t> counts(mesh().triangles.size());
  for (int t = 0; t < mesh().num_triangles(); ++t) {
    if (t % 4096 == 0) control.throw_if_stopped();
    std::int64_t& count = counts[t];
    for_each_texel(
        corners_in_texels(t), rect(),
        [&](int x, int y, double, double, double inside) {
          std::int32_t& found = triangles_[TexelId{y} * width_ + x];
          if (found >= 0) {
            if (inside > kOverlapTolerance) ++num_overlapping_;
            return;
          }
          found = t;
          ++count;
        },
        [&] { control.throw_if_stopped(); });
  }
  num_covered_ = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  median_texel_size_mm_ = median_size(texel_sizes(), counts, num_covered_);
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

std::vector<std::int64_t> TexelMap::count_texels() const {
  std::vector<std::int64_t> counts(mesh().triangles.size());
  for (const std::int32_t t : triangles_) {
    if (t >= 0) ++counts[t];
  }
  return counts;
}

}  // namespace patinate
