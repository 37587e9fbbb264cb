#include "libcommon/atlas/texel_neighborhood.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "libcommon/core/parallel.h"

namespace patinate {

namespace {

constexpr TexelId kNoStep = std::numeric_limits<TexelId>::min();
constexpr int kLook = 4096;  // Texels or triangles between two looks at the stop.

/// Chebyshev distance from each texel to the nearest texel of another chart (or the outside), at most 255.
std::vector<std::uint8_t> distance_to_border(const TexelMap& map, const RunControl& control) {
  const int w = map.width(), h = map.height();
  std::vector<std::uint8_t> distance(static_cast<std::size_t>(map.num_texels()));
  const auto at = [&](int x, int y) -> std::uint8_t& { return distance[static_cast<std::size_t>(TexelId{y} * w + x)]; };
  for (int y = 0; y < h; ++y) {
    control.throw_if_stopped();
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
    control.throw_if_stopped();
    for (int x = 0; x < w; ++x) {
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) relax(x, y, dx, dy);
    }
  }
  for (int y = h - 1; y >= 0; --y) {
    control.throw_if_stopped();
    for (int x = w - 1; x >= 0; --x) {
      for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) relax(x, y, dx, dy);
    }
  }
  return distance;
}

/// floor(v + 0.5) for |v| < 2^20, without a call.
std::int32_t nearest(double v) {
  constexpr std::int32_t kUp = 1 << 20;
  return static_cast<std::int32_t>(v + 0.5 + kUp) - kUp;
}

struct TexelStep {
  int x, y;
};
constexpr std::array<TexelStep, TexelNeighborhood::kNumAdjacent> kAdjacent{{{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

}  // namespace

TexelNeighborhood::TexelNeighborhood(const TexelMap& map, std::vector<Vec2> offsets_mm, std::shared_ptr<const FlowFrames> frames, double pixel_mm, const RunControl& control)
    : map_(map), offsets_mm_(std::move(offsets_mm)), frames_(std::move(frames)), pixel_mm_(pixel_mm), band_row_(static_cast<std::size_t>(map.num_texels()), -1) {
  const std::vector<std::uint8_t> distance = distance_to_border(map, control);
  std::vector<int> reach(map.mesh().triangles.size());  // Largest texel step of any offset, per triangle.
  for (std::size_t t = 0; t < reach.size(); ++t) {
    if (t % kLook == 0) control.throw_if_stopped();
    const Eigen::Matrix2d to_texels = map.texels_per_mm(static_cast<int>(t), (*frames_)[t]);
    double largest = 1.0;
    for (const Vec2& offset : offsets_mm_) largest = std::max(largest, (to_texels * offset).cwiseAbs().maxCoeff());
    reach[t] = static_cast<int>(std::min(std::ceil(largest), 1e6));
  }
  std::vector<TexelId> band;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (t % kLook == 0) control.throw_if_stopped();
    if (!map.is_covered(t)) continue;
    const auto i = static_cast<std::size_t>(t);
    if (distance[i] > reach[static_cast<std::size_t>(map.triangle(t))]) continue;
    band_row_[i] = static_cast<std::int32_t>(band.size());
    band.push_back(t);
  }
  num_stored_ = static_cast<std::int64_t>(band.size());
  stored_.resize(band.size() * size());
  parallel_for(num_stored_, 4096, control, [&](std::int64_t begin, std::int64_t end) {
    std::vector<TexelNeighbor> found(size());
    std::vector<Vec2> offsets = offsets_mm_;
    offsets.resize(size());
    for (auto row = static_cast<std::size_t>(begin); row < static_cast<std::size_t>(end); ++row) {
      const Eigen::Matrix2d to_mm = pixels_per_texel(map_.triangle(band[row])) * pixel_mm_;
      for (std::size_t k = 0; k < kNumAdjacent; ++k) offsets[first_adjacent() + k] = to_mm * Vec2(kAdjacent[k].x, kAdjacent[k].y);
      map_.gather(band[row], *frames_, offsets, found);
      for (std::size_t k = 0; k < size(); ++k) {
        const PixelNeighbor n = in_pixels(found[k]);
        if (n.texel >= 0) stored_[row * size() + k] = {static_cast<std::uint32_t>(n.texel), n.x, n.y};
      }
    }
  });
}

PixelNeighbor TexelNeighborhood::in_pixels(const TexelNeighbor& n) const {
  constexpr double kFarthest = 127.0;
  const Vec2 pixels = n.offset_mm / pixel_mm_;
  if (n.texel < 0 || !(pixels.cwiseAbs().maxCoeff() <= kFarthest)) return {};
  const auto fixed = [](double v) { return static_cast<std::int16_t>(nearest(v * PixelNeighbor::kOne)); };
  return {n.texel, fixed(pixels.x()), fixed(pixels.y())};
}

Eigen::Matrix2d TexelNeighborhood::pixels_per_texel(int triangle) const {
  return (*frames_)[static_cast<std::size_t>(triangle)].transpose() * map_.mm_per_texel(triangle) / pixel_mm_;
}

/// As TexelMap::gather() for a texel that is far from its chart's border; `texel` is how far on.
void TexelNeighborhood::find_steps(int triangle, std::span<PixelNeighbor> steps) const {
  const FlowFrame& frame = (*frames_)[static_cast<std::size_t>(triangle)];
  const Eigen::Matrix2d to_texels = map_.texels_per_mm(triangle, frame), to_mm = frame.transpose() * map_.mm_per_texel(triangle);
  for (std::size_t k = 0; k < size(); ++k) {
    const Vec2 step = k < first_adjacent() ? Vec2(to_texels * offsets_mm_[k]) : Vec2(kAdjacent[k - first_adjacent()].x, kAdjacent[k - first_adjacent()].y);
    const TexelId dx = nearest(step.x()), dy = nearest(step.y());  // At most 255: the border of the chart lies farther.
    steps[k] = in_pixels({0, to_mm * Vec2(static_cast<double>(dx), static_cast<double>(dy))});
    steps[k].texel = steps[k].texel < 0 ? kNoStep : dy * map_.width() + dx;
  }
}

std::span<const PixelNeighbor> TexelNeighborhood::Cursor::at(TexelId t) {
  const TexelNeighborhood& all = neighborhood_;
  const std::int32_t row = all.band_row_[static_cast<std::size_t>(t)];
  if (row >= 0) {
    const auto stored = std::span(all.stored_).subspan(static_cast<std::size_t>(row) * all.size(), all.size());
    for (std::size_t k = 0; k < stored.size(); ++k) found_[k] = {stored[k].texel == Stored::kNone ? -1 : TexelId{stored[k].texel}, stored[k].x, stored[k].y};
    return found_;
  }
  const int triangle = all.map_.triangle(t);
  const std::size_t kept = static_cast<std::size_t>(triangle) % kNumKept;
  const auto steps = std::span(steps_).subspan(kept * all.size(), all.size());
  if (triangle != triangles_[kept]) all.find_steps(triangle, steps);
  triangles_[kept] = triangle;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    found_[k] = steps[k];
    found_[k].texel = steps[k].texel == kNoStep ? -1 : t + steps[k].texel;
  }
  return found_;
}

}  // namespace patinate
