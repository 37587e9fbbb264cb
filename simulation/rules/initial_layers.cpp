#include "simulation/rules/initial_layers.h"

#include <algorithm>
#include <cmath>

#include "simulation/rules/start_values.h"

namespace patinate::simulation {

namespace {

enum class LayerQuantity { Thickness, Adhesion };

StartExpression layer_expression(const Scene& scene, std::size_t object, std::size_t layer, LayerQuantity quantity) {
  const SceneObject& of = scene.objects[object];
  const bool is_thickness = quantity == LayerQuantity::Thickness;
  return {.object = object,
          .text = is_thickness ? of.layers[layer].thickness_um : of.layers[layer].adhesion,
          .subject = std::string(is_thickness ? "thickness_um" : "adhesion") + " of layer '" + of.layers[layer].name +
                     "' of object '" + of.name + "'"};
}

/// Where texels of the object are, quanta become what the values say. @param most  In the values' unit.
void lay_quanta(std::size_t object, int layer, TileIndex tile, std::span<const float> values, double most, double one,
                MaterialAtlas& quanta) {
  const SurfaceAtlas& surface = quanta.surface();
  std::array<std::uint16_t, TileGrid::kTileTexels> before;
  quanta.read_tile(layer, tile, before);
  std::array<std::uint16_t, TileGrid::kTileTexels> after = before;
  for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
    const int triangle = surface.triangle(tile * TileGrid::kTileTexels + i);
    if (triangle < 0 || static_cast<std::size_t>(surface.object(triangle)) != object) continue;
    const double value = std::clamp(static_cast<double>(values[i]), 0.0, most);
    after[i] = static_cast<std::uint16_t>(std::floor(value * one + 0.5));
  }
  if (after == before) return;
  const std::span<std::uint16_t> stored = quanta.writable_tile(layer, tile);
  std::copy(after.begin(), after.end(), stored.begin());
}

}  // namespace

std::vector<std::string> layer_map_names(const Scene& scene, std::size_t object, std::size_t layer) {
  std::vector<std::string> names = start_names(scene, layer_expression(scene, object, layer, LayerQuantity::Thickness));
  for (const std::string& name : start_names(scene, layer_expression(scene, object, layer, LayerQuantity::Adhesion)))
    names.push_back(name);
  return names;
}

void lay_initial_layers(const Scene& scene, const SceneMesh& scene_mesh, LayerAtlas& layers,
                        const RunControl& control) {
  struct Laid {
    int layer;
    LayerQuantity quantity;
  };
  std::vector<StartExpression> expressions;
  std::vector<Laid> laid;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    for (std::size_t l = 1; l < scene.objects[o].layers.size(); ++l) {
      for (const LayerQuantity quantity : {LayerQuantity::Thickness, LayerQuantity::Adhesion}) {
        expressions.push_back(layer_expression(scene, o, l, quantity));
        laid.push_back({static_cast<int>(l), quantity});
      }
    }
  }
  evaluate_at_start(
      scene, scene_mesh, layers.surface(), expressions,
      [&](std::size_t i, TileIndex tile, std::span<const float> values) {
        const bool is_thickness = laid[i].quantity == LayerQuantity::Thickness;
        lay_quanta(expressions[i].object, laid[i].layer, tile, values, is_thickness ? kMaxThicknessUm : 1.0,
                   is_thickness ? LayerAtlas::kQuantaPerUm : LayerAtlas::kAdhesionOne,
                   is_thickness ? layers.thickness() : layers.adhesion());
      },
      control);
  layers.renew_tops(control);
  layers.begin_accounts(control);
}

}  // namespace patinate::simulation
