#include "simulation/layers/initial_cracks.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <vector>

#include "libcommon/image/thinned_lines.h"
#include "patinate/atlas/dilate.h"
#include "simulation/layers/chart_walk.h"

namespace patinate::simulation {

namespace {

/// Thinning takes half of its width from a line's end. Lines that go on beyond their charts lose it there.
constexpr int kBeyondTexels = 16;
/// Texels over which the way of a line's end is measured: steps of one texel have few directions.
constexpr int kTailTexels = 6;

bool can_crack(const LayerAtlas& layers, int layer, TexelIndex t) {
  const SurfaceAtlas& surface = layers.surface();
  return surface.is_covered(t) && layers.thickness().amount(layer, t) != 0 &&
         layers.cracks(surface.object(surface.triangle(t)), layer).has_value();
}

std::optional<std::array<int, 2>> only_neighbor(const ImageU8& lines, int x, int y) {
  const std::array<bool, 8> around = set_neighbors(lines, x, y);
  if (std::count(around.begin(), around.end(), true) != 1) return std::nullopt;
  const auto k = std::find(around.begin(), around.end(), true) - around.begin();
  return std::array{x + kAroundX[k], y + kAroundY[k]};
}

/// From a place on a line some texels before its end toward the end.
std::array<float, 2> way_of_end(const ImageU8& lines, int x, int y, const std::array<int, 2>& next) {
  ImageU8 left(2 * kTailTexels + 1, 2 * kTailTexels + 1, 1, 1);  // Not yet passed, around the end.
  left.at(kTailTexels, kTailTexels) = 0;
  std::array<int, 2> at = next;
  for (int k = 1; k < kTailTexels; ++k) {
    left.at(at[0] - x + kTailTexels, at[1] - y + kTailTexels) = 0;
    std::optional<std::array<int, 2>> on;
    for (std::size_t i = 0; i < 8; ++i) {
      const int nx = at[0] + kAroundX[i], ny = at[1] + kAroundY[i];
      if (is_set(lines, nx, ny) && left.at(nx - x + kTailTexels, ny - y + kTailTexels) != 0 && !on) on = {nx, ny};
    }
    if (!on) break;
    at = *on;
  }
  return {static_cast<float>(x - at[0]), static_cast<float>(y - at[1])};
}

/// A direction of the atlas on the surface (CrackTip::way).
std::array<float, 2> on_surface(const SurfaceAtlas& surface, TexelIndex t, const std::array<float, 2>& way) {
  const Eigen::Matrix<float, 3, 2>& step = surface.mm_per_texel(surface.triangle(t));
  const Eigen::Vector3f along = step * Eigen::Vector2f(way[0], way[1]), row = step.col(0).normalized();
  const Eigen::Vector3f column = (step.col(1) - step.col(1).dot(row) * row).normalized();
  const Eigen::Vector2f unit = Eigen::Vector2f(along.dot(row), along.dot(column)).normalized();
  return {unit.x(), unit.y()};
}

/// Center lines of what is marked on the surface, which go on to the borders of its charts.
ImageU8 center_lines(const ImageU8& marked, const SurfaceAtlas& surface) {
  const int width = marked.width(), height = marked.height();
  ImageU8 around(width + 2 * kBeyondTexels, height + 2 * kBeyondTexels), coverage = around;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!surface.is_covered(surface.grid().index(x, y))) continue;
      around.at(x + kBeyondTexels, y + kBeyondTexels) = marked.at(x, y);
      coverage.at(x + kBeyondTexels, y + kBeyondTexels) = 255;
    }
  }
  dilate(around, coverage, kBeyondTexels);
  around = thinned(around);
  ImageU8 lines(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) lines.at(x, y) = around.at(x + kBeyondTexels, y + kBeyondTexels);
  }
  return lines;
}

/// Whether the layer goes on ahead of a tip without a crack.
bool has_way(const LayerAtlas& layers, const CrackTip& tip) {
  ChartWalk walk(layers.surface(), tip.texel, tip.place, tip.way);
  constexpr int kMostSteps = 4;  // A step leaves the texel, but for rounding.
  for (int k = 0; k < kMostSteps && walk.texel() == tip.texel; ++k) {
    if (!walk.advance()) return false;
  }
  const int layer = static_cast<int>(tip.layer);
  return can_crack(layers, layer, walk.texel()) && layers.crack().amount(layer, walk.texel()) == 0;
}

}  // namespace

void lay_cracks(const ImageU8& marked, int layer, LayerAtlas& layers) {
  const SurfaceAtlas& surface = layers.surface();
  const TileGrid& grid = surface.grid();
  const ImageU8 lines = center_lines(marked, surface);
  std::vector<CrackTip> ends;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const TexelIndex t = grid.index(x, y);
      if (lines.at(x, y) == 0 || !can_crack(layers, layer, t)) continue;
      layers.add_crack(layer, t);
      const std::optional<std::array<int, 2>> next = only_neighbor(lines, x, y);
      if (!next) continue;
      constexpr float kHalf = 0.5F;
      ends.push_back({.texel = t,
                      .layer = static_cast<std::uint32_t>(layer),
                      .place = {static_cast<float>(x) + kHalf, static_cast<float>(y) + kHalf},
                      .way = on_surface(surface, t, way_of_end(lines, x, y, *next))});
    }
  }
  std::copy_if(ends.begin(), ends.end(), std::back_inserter(layers.tips()),
               [&](const CrackTip& tip) { return has_way(layers, tip); });
}

}  // namespace patinate::simulation
