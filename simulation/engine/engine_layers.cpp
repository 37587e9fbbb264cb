// What files keep of a scene's layers.
#include <algorithm>
#include <cmath>

#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/engine/engine_state.h"

namespace patinate::simulation {

namespace {

/// Planes of a layer: its thickness, its adhesion, and an amount below it for each material that comes there.
struct LayerPlane {
  int layer = 1;
  int number = 0;  ///< 0: thickness, 1: adhesion, then of the interface's materials.
};

LayerPlane plane_at(std::size_t index, const std::vector<int>& materials) {
  const std::size_t each = 2 + materials.size();
  return {.layer = 1 + static_cast<int>(index / each), .number = static_cast<int>(index % each)};
}

template <class Layers>
auto& quanta_of(Layers& layers, const LayerPlane& plane) {
  return plane.number == 0   ? layers.thickness()
         : plane.number == 1 ? layers.adhesion()
                             : layers.interface_below(plane.layer);
}

/// In place of the material of MaterialAtlas.
int index_of(const LayerPlane& plane, const std::vector<int>& materials) {
  return plane.number < 2 ? plane.layer : materials[plane.number - 2];
}

double one_of(const LayerPlane& plane) { return plane.number == 0 ? LayerAtlas::kQuantaPerUm : double{kAmountOne}; }

double most_of(const LayerPlane& plane) {
  return plane.number == 0 ? kMaxThicknessUm : plane.number == 1 ? 1.0 : double{kMaxAmount} / kAmountOne;
}

}  // namespace

std::string Simulation::state_hash() const {
  const std::string amounts = atlas().hash();
  if (!state_->layers) return amounts;
  ContentHash hash;
  hash.add(amounts);
  hash.add(state_->layers->hash());
  return hash.hex();
}

std::vector<std::string> Simulation::layer_map_names() const {
  std::vector<std::string> names;
  for (int l = 1; state_->layers && l < state_->layers->num_layers(); ++l) {
    const std::string layer = "layer" + std::to_string(l) + ".";
    names.push_back(layer + "thickness_um");
    names.push_back(layer + "adhesion");
    for (const int m : state_->interface_materials) names.push_back(layer + "interface." + state_->scene.materials[m]);
  }
  return names;
}

ImageF Simulation::layer_map(std::size_t index) const {
  const State& s = *state_;
  const LayerPlane plane = plane_at(index, s.interface_materials);
  const LayerAtlas& layers = *s.layers;
  const MaterialAtlas& quanta = quanta_of(layers, plane);
  const int number = index_of(plane, s.interface_materials);
  const TileGrid& grid = s.surface.grid();
  ImageF image(grid.width, grid.height);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const TexelIndex t = grid.index(x, y);
      if (s.surface.is_covered(t)) image.at(x, y) = static_cast<float>(quanta.amount(number, t) / one_of(plane));
    }
  }
  return image;
}

void Simulation::set_layer_map(std::size_t index, const ImageF& values) {
  State& s = *state_;
  const TileGrid& grid = s.surface.grid();
  if (values.width() != grid.width || values.height() != grid.height) {
    throw InvalidInput("the map of a layer is " + size_text(values.width(), values.height()) +
                       " texels; the atlas has " + size_text(grid.width, grid.height));
  }
  const LayerPlane plane = plane_at(index, s.interface_materials);
  const auto most = static_cast<float>(most_of(plane));
  for (const float v : values.values()) {
    if (!(v >= 0.0F && v <= most))
      throw InvalidInput("the map of a layer has " + number_text(static_cast<double>(v)) + "; use [0, " +
                         number_text(static_cast<double>(most)) + "]");
  }
  MaterialAtlas& quanta = quanta_of(*s.layers, plane);
  const int number = index_of(plane, s.interface_materials);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const TexelIndex t = grid.index(x, y);
      const auto own = static_cast<std::uint16_t>(std::lround(static_cast<double>(values.at(x, y)) * one_of(plane)));
      if (!s.surface.is_covered(t) || quanta.amount(number, t) == own) continue;
      quanta.writable_tile(number, TileGrid::tile_of(t))[t % TileGrid::kTileTexels] = own;
      s.changed_in[TileGrid::tile_of(t)] = static_cast<std::int32_t>(s.iteration);
    }
  }
  if (plane.number == 0) s.layers->renew_tops();
  s.rules->wake_everything();
}

}  // namespace patinate::simulation
