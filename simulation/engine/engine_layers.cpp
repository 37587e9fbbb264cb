// What files keep of a scene's layers.
#include <algorithm>
#include <cmath>

#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/engine/engine_state.h"

namespace patinate::simulation {

namespace {

enum class PlaneKind { Thickness, Adhesion, Stress, Crack, Interface };

/// A map of a layer.
struct LayerPlane {
  int layer = 1;
  PlaneKind kind = PlaneKind::Thickness;
  int material = -1;  ///< At the interface.
};

bool does_crack(const LayerAtlas& layers, int layer) {
  for (int object = 0; object < layers.num_objects(); ++object) {
    if (layer < layers.num_layers(object) && layers.cracks(object, layer)) return true;
  }
  return false;
}

/// In their order, by layer. @param materials  That come to interfaces.
std::vector<LayerPlane> planes_of(const LayerAtlas& layers, const std::vector<int>& materials) {
  std::vector<LayerPlane> planes;
  for (int l = 1; l < layers.num_layers(); ++l) {
    for (const PlaneKind kind : {PlaneKind::Thickness, PlaneKind::Adhesion}) planes.push_back({l, kind});
    for (const int m : materials) planes.push_back({l, PlaneKind::Interface, m});
    if (!does_crack(layers, l)) continue;
    for (const PlaneKind kind : {PlaneKind::Stress, PlaneKind::Crack}) planes.push_back({l, kind});
  }
  return planes;
}

template <class Layers>
auto& quanta_of(Layers& layers, const LayerPlane& plane) {
  switch (plane.kind) {
    case PlaneKind::Thickness:
      return layers.thickness();
    case PlaneKind::Adhesion:
      return layers.adhesion();
    case PlaneKind::Stress:
      return layers.stress();
    case PlaneKind::Crack:
      return layers.crack();
    case PlaneKind::Interface:
      break;
  }
  return layers.interface_below(plane.layer);
}

/// In place of the material of MaterialAtlas.
int index_of(const LayerPlane& plane) { return plane.kind == PlaneKind::Interface ? plane.material : plane.layer; }

double one_of(const LayerPlane& plane) {
  return plane.kind == PlaneKind::Thickness ? LayerAtlas::kQuantaPerUm : double{kAmountOne};
}

double most_of(const LayerPlane& plane) {
  switch (plane.kind) {
    case PlaneKind::Thickness:
      return kMaxThicknessUm;
    case PlaneKind::Adhesion:
    case PlaneKind::Crack:
      return 1.0;
    case PlaneKind::Stress:
    case PlaneKind::Interface:
      break;
  }
  return double{kMaxAmount} / kAmountOne;
}

std::string name_of(const LayerPlane& plane, const std::vector<std::string>& materials) {
  const std::string layer = "layer" + std::to_string(plane.layer) + ".";
  switch (plane.kind) {
    case PlaneKind::Thickness:
      return layer + "thickness_um";
    case PlaneKind::Adhesion:
      return layer + "adhesion";
    case PlaneKind::Stress:
      return layer + "stress";
    case PlaneKind::Crack:
      return layer + "crack";
    case PlaneKind::Interface:
      break;
  }
  return layer + "interface." + materials[plane.material];
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
  if (!state_->layers) return names;
  for (const LayerPlane& plane : planes_of(*state_->layers, state_->interface_materials))
    names.push_back(name_of(plane, state_->scene.materials));
  return names;
}

ImageF Simulation::layer_map(std::size_t index) const {
  const State& s = *state_;
  const LayerPlane plane = planes_of(*s.layers, s.interface_materials)[index];
  const LayerAtlas& layers = *s.layers;
  const MaterialAtlas& quanta = quanta_of(layers, plane);
  const int number = index_of(plane);
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
  const LayerPlane plane = planes_of(*s.layers, s.interface_materials)[index];
  const auto most = static_cast<float>(most_of(plane));
  for (const float v : values.values()) {
    if (!(v >= 0.0F && v <= most))
      throw InvalidInput("the map of a layer has " + number_text(static_cast<double>(v)) + "; use [0, " +
                         number_text(static_cast<double>(most)) + "]");
  }
  MaterialAtlas& quanta = quanta_of(*s.layers, plane);
  const int number = index_of(plane);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const TexelIndex t = grid.index(x, y);
      const auto own = static_cast<std::uint16_t>(std::lround(static_cast<double>(values.at(x, y)) * one_of(plane)));
      if (!s.surface.is_covered(t) || quanta.amount(number, t) == own) continue;
      quanta.writable_tile(number, TileGrid::tile_of(t))[t % TileGrid::kTileTexels] = own;
      s.changed_in[TileGrid::tile_of(t)] = static_cast<std::int32_t>(s.iteration);
    }
  }
  if (plane.kind == PlaneKind::Thickness || s.layers->has_cracks()) s.layers->renew_tops();
  s.rules->wake_everything();
}

}  // namespace patinate::simulation
