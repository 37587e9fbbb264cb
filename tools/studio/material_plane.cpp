#include "tools/studio/material_plane.h"

#include <algorithm>
#include <numeric>

#include "app/output/aging_mesh.h"
#include "simulation/job/frame_maps.h"

namespace patinate::studio {

namespace {

std::uint8_t code(double share) { return static_cast<std::uint8_t>(255.0 * std::clamp(share, 0.0, 1.0) + 0.5); }

}  // namespace

MaterialPlane::MaterialPlane(const simulation::Scene& scene, const ScreenLayout& layout)
    : layout_(&layout),
      has_metal_(simulation::TexelMetal::is_in(scene)),
      film_(simulation::film_material(scene)),
      plant_(simulation::plant_material(scene)),
      bytes_(std::size_t{layout.num_tiles()} * kTileBytes, 0) {}

bool MaterialPlane::is_in(const simulation::Scene& scene) {
  return simulation::TexelMetal::is_in(scene) || simulation::film_material(scene) >= 0 ||
         simulation::plant_material(scene) >= 0;
}

std::vector<ScreenTile> MaterialPlane::update(const simulation::Simulation& simulation) {
  std::vector<ScreenTile> tiles;
  if (seen_ < 0) {
    tiles.resize(layout_->num_tiles());
    std::iota(tiles.begin(), tiles.end(), ScreenTile{0});
  } else {
    tiles = layout_->showing(simulation.dirty_since(seen_));
  }
  seen_ = simulation.iteration();
  const simulation::MaterialAtlas& atlas = simulation.atlas();
  const simulation::TexelMetal metal(simulation);
  const auto amount = [&](int material, simulation::TexelIndex t) {
    return static_cast<double>(atlas.amount(material, t)) / simulation::kAmountOne;
  };
  std::vector<ScreenTile> changed;
  for (const ScreenTile tile : tiles) {
    const std::array<simulation::TexelIndex, 64> sources = layout_->sources(tile);
    std::array<std::uint8_t, kTileBytes> now{};
    for (std::size_t i = 0; i < 64; ++i) {
      const simulation::TexelIndex t = sources[i];
      if (t == simulation::kNoTexel || !atlas.surface().is_covered(t)) continue;
      if (has_metal_) now[4 * i] = code(static_cast<double>(metal.at(t)));
      if (film_ >= 0) now[4 * i + 1] = code(amount(film_, t) / app::kWetFilm);
      if (plant_ >= 0) now[4 * i + 2] = code(amount(plant_, t));
    }
    std::uint8_t* old = &bytes_[std::size_t{tile} * kTileBytes];
    if (std::equal(now.begin(), now.end(), old)) continue;
    std::copy(now.begin(), now.end(), old);
    changed.push_back(tile);
  }
  return changed;
}

}  // namespace patinate::studio
