#include "simulation/rules/initial_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "simulation/rules/start_values.h"
#include "simulation/rules/tension_axes.h"

namespace patinate::simulation {

namespace {

enum class LayerQuantity { Thickness, Adhesion, Strength };
constexpr std::array<std::string_view, 3> kQuantityNames{"thickness_um", "adhesion", "cracks/strength"};

/// What a layer states.
std::vector<LayerQuantity> quantities_of(const Layer& layer) {
  std::vector<LayerQuantity> quantities{LayerQuantity::Thickness, LayerQuantity::Adhesion};
  if (layer.cracks) quantities.push_back(LayerQuantity::Strength);
  return quantities;
}

StartExpression layer_expression(const Scene& scene, std::size_t object, std::size_t layer, LayerQuantity quantity) {
  const SceneObject& of = scene.objects[object];
  const Layer& stated = of.layers[layer];
  return {.object = object,
          .text = quantity == LayerQuantity::Thickness  ? stated.thickness_um
                  : quantity == LayerQuantity::Adhesion ? stated.adhesion
                                                        : stated.cracks->strength,
          .subject = std::string(kQuantityNames[static_cast<std::size_t>(quantity)]) + " of layer '" + stated.name +
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
  std::vector<std::string> names;
  for (const LayerQuantity quantity : quantities_of(scene.objects[object].layers[layer])) {
    for (const std::string& name : start_names(scene, layer_expression(scene, object, layer, quantity)))
      names.push_back(name);
  }
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
      for (const LayerQuantity quantity : quantities_of(scene.objects[o].layers[l])) {
        expressions.push_back(layer_expression(scene, o, l, quantity));
        laid.push_back({static_cast<int>(l), quantity});
      }
    }
  }
  evaluate_at_start(
      scene, scene_mesh, layers.surface(), expressions,
      [&](std::size_t i, TileIndex tile, std::span<const float> values) {
        const auto lay = [&](double most, double one, MaterialAtlas& quanta) {
          lay_quanta(expressions[i].object, laid[i].layer, tile, values, most, one, quanta);
        };
        switch (laid[i].quantity) {
          case LayerQuantity::Thickness:
            return lay(kMaxThicknessUm, LayerAtlas::kQuantaPerUm, layers.thickness());
          case LayerQuantity::Adhesion:
            return lay(1.0, LayerAtlas::kAdhesionOne, layers.adhesion());
          case LayerQuantity::Strength:
            return lay(kMaxStrength, kAmountOne, layers.strength());
        }
      },
      control);
  lay_tension_axes(scene, scene_mesh, layers);
  layers.renew_tops(control);
  layers.begin_accounts(control);
}

void replace_layers(LayerAtlas&& restored, LayerAtlas& layers) {
  restored.strength() = std::move(layers.strength());
  for (int l = 1; l < layers.num_layers(); ++l) restored.tension_axes(l) = std::move(layers.tension_axes(l));
  layers = std::move(restored);
}

}  // namespace patinate::simulation
