#include "tools/studio/overlay_plane.h"

#include <algorithm>
#include <numeric>

#include "libcommon/core/error.h"

namespace patinate {

OverlayPlane::OverlayPlane(const std::string& name, const Simulation& simulation, const ScreenLayout& layout)
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
    const std::array<TexelIndex, 64> sources = layout_->sources(tile);
    std::array<std::uint8_t, 64> now{};
    for (std::size_t i = 0; i < 64; ++i) {
      if (sources[i] != kNoTexel) now[i] = static_cast<std::uint8_t>(std::clamp(255.0 * value(sources[i]) / high_ + 0.5, 0.0, 255.0));
    }
    std::uint8_t* old = &bytes_[std::size_t{tile} * 64];
    if (std::equal(now.begin(), now.end(), old)) continue;
    std::copy(now.begin(), now.end(), old);
    changed.push_back(tile);
  }
  return changed;
}

std::vector<ScreenTile> OverlayPlane::update(const Simulation& simulation) {
  const MaterialAtlas& atlas = simulation.atlas();
  if (material_ >= 0) {
    std::vector<ScreenTile> tiles;
    if (seen_ < 0) {
      tiles.resize(layout_->num_tiles());
      std::iota(tiles.begin(), tiles.end(), ScreenTile{0});
    } else {
      tiles = layout_->showing(simulation.dirty_since(seen_));
    }
    seen_ = simulation.iteration();
    return write(tiles, [&](TexelIndex t) { return atlas.surface().is_covered(t) ? static_cast<double>(atlas.amount(material_, t)) / kAmountOne : 0.0; });
  }
  if (seen_ == simulation.iteration()) return {};
  seen_ = simulation.iteration();
  const ImageF values = simulation.parameter_map(name_).values;
  const float top = *std::max_element(values.values().begin(), values.values().end());
  while (high_ < static_cast<double>(top)) high_ *= 2.0;
  std::vector<ScreenTile> all(layout_->num_tiles());
  std::iota(all.begin(), all.end(), ScreenTile{0});
  const TileGrid& grid = atlas.surface().grid();
  return write(all, [&](TexelIndex t) { return static_cast<double>(values.at(grid.x(t), grid.y(t))); });
}

}  // namespace patinate
