#include "libcommon/atlas/texel_neighborhood.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/core/parallel.h"

namespace patinate {

namespace {

/// Chebyshev distance from each texel to the nearest texel of another chart (or the outside), at most 255.
std::vector<std::uint8_t> distance_to_border(const TexelMap& map) {
  const int w = map.width(), h = map.height();
  std::vector<std::uint8_t> distance(static_cast<std::size_t>(map.num_texels()));
  const auto at = [&](int x, int y) -> std::uint8_t& { return distance[static_cast<std::size_t>(TexelId{y} * w + x)]; };
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const int own = map.chart(TexelId{y} * w + x);
      bool is_border = own < 0 || x == 0 || y == 0 || x == w - 1 || y == h - 1;
      for (int dy = -1; dy <= 1 && !is_border; ++dy) {
        for (int dx = -1; dx <= 1 && !is_border; ++dx) is_border = map.chart(TexelId{y + dy} * w + x + dx) != own;
      }
      at(x, y) = is_border ? (own < 0 ? 0 : 1) : 255;
    }
  }
  const auto relax = [&](int x, int y, int dx, int dy) {
    const int qx = x + dx, qy = y + dy;
    if (qx < 0 || qy < 0 || qx >= w || qy >= h) return;
    at(x, y) = static_cast<std::uint8_t>(std::min<int>(at(x, y), at(qx, qy) + 1));
  };
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) relax(x, y, dx, dy);
    }
  }
  for (int y = h - 1; y >= 0; --y) {
    for (int x = w - 1; x >= 0; --x) {
      for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) relax(x, y, dx, dy);
    }
  }
  return distance;
}

}  // namespace

TexelNeighborhood::TexelNeighborhood(const TexelMap& map, std::vector<Vec2> offsets_mm, const RunControl& control)
    : map_(map), offsets_mm_(std::move(offsets_mm)), band_row_(static_cast<std::size_t>(map.num_texels()), -1) {
  const std::vector<std::uint8_t> distance = distance_to_border(map);
  std::vector<int> reach(map.mesh().triangles.size());  // Largest texel step of any offset, per triangle.
  for (std::size_t t = 0; t < reach.size(); ++t) {
    const Eigen::Matrix2d to_texels = map.texels_per_mm(static_cast<int>(t));
    double largest = 0.0;
    for (const Vec2& offset : offsets_mm_) largest = std::max(largest, (to_texels * offset).cwiseAbs().maxCoeff());
    reach[t] = static_cast<int>(std::min(std::ceil(largest), 1e6));
  }
  std::vector<TexelId> band;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const auto i = static_cast<std::size_t>(t);
    if (distance[i] > reach[static_cast<std::size_t>(map.point(t).triangle)]) continue;
    band_row_[i] = static_cast<std::int32_t>(band.size());
    band.push_back(t);
  }
  num_stored_ = static_cast<std::int64_t>(band.size());
  stored_.resize(band.size() * size());
  parallel_for(num_stored_, 4096, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto row = static_cast<std::size_t>(begin); row < static_cast<std::size_t>(end); ++row) {
      map_.gather(band[row], offsets_mm_, std::span(stored_).subspan(row * size(), size()));
    }
  });
}

void TexelNeighborhood::gather(TexelId t, std::span<TexelId> out) const {
  const std::int32_t row = band_row_[static_cast<std::size_t>(t)];
  if (row >= 0) {
    std::copy_n(stored_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(row) * size()), size(), out.begin());
    return;
  }
  const Eigen::Matrix2d to_texels = map_.texels_per_mm(map_.point(t).triangle);
  for (std::size_t k = 0; k < size(); ++k) {
    const Vec2 step = to_texels * offsets_mm_[k];
    out[k] = t + static_cast<TexelId>(std::floor(step.y() + 0.5)) * map_.width() +
             static_cast<TexelId>(std::floor(step.x() + 0.5));
  }
}

}  // namespace patinate
