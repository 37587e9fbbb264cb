#include "tools/studio/overlay_plane.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::studio {

namespace {

constexpr double kOutside = 0.02;  ///< The share of texels that lies beyond either end of a range.
constexpr double kNarrow = 0.25;   ///< A range begins at 0 unless its low end is at least this share of its high one.
constexpr std::size_t kBins = 65536;  ///< Bins of a histogram of roots: a value is known to a part in 10,000 down to a
                                      ///< ten-thousandth of the most.
constexpr int kDigits = 3;

/// The least power of two that is not below, 1 for nothing.
double top_of(double most) { return most > 0.0 ? std::exp2(std::ceil(std::log2(most))) : 1.0; }

/// Percentile of `counts`, by root up to `top`: the value that a share lies below.
double percentile(const std::vector<std::uint32_t>& counts, std::uint64_t sum, double share, double top) {
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    below += counts[i];
    if (static_cast<double>(below) < share * static_cast<double>(sum)) continue;
    const double root = static_cast<double>(i + 1) / static_cast<double>(kBins);
    return top * root * root;
  }
  return top;
}

}  // namespace

OverlayPlane::OverlayPlane(const std::string& name, const simulation::Simulation& simulation,
                           const ScreenLayout& layout)
    : name_(name), layout_(&layout), bytes_(std::size_t{layout.num_tiles()} * 64, 0) {
  const std::vector<std::string>& materials = simulation.scene().materials;
  const auto found = std::find(materials.begin(), materials.end(), name);
  if (found != materials.end()) {
    material_ = static_cast<int>(found - materials.begin());
    return;
  }
  try {
    (void)simulation.parameter_map(name);
  } catch (const InvalidInput&) {
    throw InvalidInput("overlay: found \"" + name + "\"; expected one that the scene's \"overlays\" name");
  }
}

std::vector<ScreenTile> OverlayPlane::write(std::span<const ScreenTile> tiles, const auto& value) {
  std::vector<ScreenTile> changed;
  for (const ScreenTile tile : tiles) {
    const std::array<simulation::TexelIndex, 64> sources = layout_->sources(tile);
    std::array<std::uint8_t, 64> now{};
    for (std::size_t i = 0; i < 64; ++i) {
      if (sources[i] != simulation::kNoTexel)
        now[i] = static_cast<std::uint8_t>(255.0 * std::sqrt(std::clamp(value(sources[i]) / high_, 0.0, 1.0)) + 0.5);
    }
    std::uint8_t* old = &bytes_[std::size_t{tile} * 64];
    if (std::equal(now.begin(), now.end(), old)) continue;
    std::copy(now.begin(), now.end(), old);
    changed.push_back(tile);
  }
  return changed;
}

/// By texel; 0 outside the charts.
std::function<double(simulation::TexelIndex)> OverlayPlane::values_of(const simulation::Simulation& simulation) const {
  const simulation::MaterialAtlas& atlas = simulation.atlas();
  if (material_ >= 0) {
    return [&atlas, m = material_](simulation::TexelIndex t) {
      return atlas.surface().is_covered(t) ? static_cast<double>(atlas.amount(m, t)) / simulation::kAmountOne : 0.0;
    };
  }
  const auto values = std::make_shared<const ImageF>(simulation.parameter_map(name_).values);
  const simulation::TileGrid& grid = atlas.surface().grid();
  return [values, &grid](simulation::TexelIndex t) { return static_cast<double>(values->at(grid.x(t), grid.y(t))); };
}

double OverlayPlane::most_of(const simulation::Simulation& simulation,
                             const std::function<double(simulation::TexelIndex)>& value) const {
  const simulation::SurfaceAtlas& surface = simulation.atlas().surface();
  double most = 0.0;
  for (simulation::TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (surface.is_covered(t)) most = std::max(most, value(t));
  }
  return most;
}

std::vector<ScreenTile> OverlayPlane::update(const simulation::Simulation& simulation) {
  if (material_ < 0 && seen_ == simulation.iteration() && seen_steps_ == simulation.num_paint_steps()) return {};
  const std::function<double(simulation::TexelIndex)> value = values_of(simulation);
  const simulation::SurfaceAtlas& surface = simulation.atlas().surface();
  bool is_whole = seen_ < 0 || material_ < 0;
  if (is_whole) {
    const double top = top_of(most_of(simulation, value));
    if (seen_ < 0 || top > high_ || 4.0 * top <= high_) high_ = top;
  } else {
    double most = 0.0;
    for (const simulation::TileIndex tile : simulation.dirty_since(seen_)) {
      for (simulation::TexelIndex t = tile * simulation::TileGrid::kTileTexels;
           t < (tile + 1) * simulation::TileGrid::kTileTexels; ++t) {
        if (surface.is_covered(t)) most = std::max(most, value(t));
      }
    }
    is_whole = most > high_;
    if (is_whole) high_ = top_of(most);
  }
  std::vector<ScreenTile> tiles;
  if (is_whole) {
    tiles.resize(layout_->num_tiles());
    std::iota(tiles.begin(), tiles.end(), ScreenTile{0});
  } else {
    tiles = layout_->showing(simulation.dirty_since(seen_));
  }
  seen_ = simulation.iteration();
  seen_steps_ = simulation.num_paint_steps();
  tiles = write(tiles, value);
  is_stale_ = is_stale_ || !tiles.empty();
  return tiles;
}

bool OverlayPlane::measure(const simulation::Simulation& simulation) {
  is_stale_ = false;
  const std::function<double(simulation::TexelIndex)> value = values_of(simulation);
  const simulation::SurfaceAtlas& surface = simulation.atlas().surface();
  std::vector<std::uint32_t> counts(kBins, 0);
  std::uint64_t sum = 0;
  double most = 0.0;
  for (simulation::TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    const double v = surface.is_covered(t) ? value(t) : 0.0;
    if (!(v > 0.0)) continue;
    most = std::max(most, v);
    ++counts[static_cast<std::size_t>(static_cast<double>(kBins - 1) * std::sqrt(std::min(1.0, v / high_)))];
    ++sum;
  }
  OverlayRange now;
  if (most > 0.0) {
    now.most = rounded(most, kDigits);
    now.high = rounded(std::min(most, percentile(counts, sum, 1.0 - kOutside, high_)), kDigits);
    const double low = rounded(percentile(counts, sum, kOutside, high_), kDigits);
    now.low = low >= kNarrow * now.high && low < now.high ? low : 0.0;
  }
  if (material_ >= 0 && 4.0 * top_of(most) <= high_) seen_ = -1;  // finer steps from the next update on
  const bool is_other = now != range_;
  range_ = now;
  return is_other;
}

}  // namespace patinate::studio
