#include "simulation/rules/initial_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/layers/initial_cracks.h"
#include "simulation/rules/start_values.h"
#include "simulation/rules/tension_axes.h"

namespace patinate::simulation {

namespace {

enum class LayerQuantity { Thickness, Adhesion, Strength, Cracks };
constexpr std::array<std::string_view, 4> kQuantityNames{"thickness_um", "adhesion", "cracks/strength",
                                                         "cracks/initial"};

/// What a layer states.
std::vector<LayerQuantity> quantities_of(const Layer& layer) {
  std::vector<LayerQuantity> quantities{LayerQuantity::Thickness, LayerQuantity::Adhesion};
  if (layer.cracks) quantities.push_back(LayerQuantity::Strength);
  if (layer.cracks && !layer.cracks->initial.empty()) quantities.push_back(LayerQuantity::Cracks);
  return quantities;
}

StartExpression layer_expression(const Scene& scene, std::size_t object, std::size_t layer, LayerQuantity quantity) {
  const SceneObject& of = scene.objects[object];
  const Layer& stated = of.layers[layer];
  return {.object = object,
          .text = quantity == LayerQuantity::Thickness  ? stated.thickness_um
                  : quantity == LayerQuantity::Adhesion ? stated.adhesion
                  : quantity == LayerQuantity::Strength ? stated.cracks->strength
                                                        : stated.cracks->initial,
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

/// Marks texels of the object where the values say that there is a crack.
void mark_cracks(std::size_t object, TileIndex tile, std::span<const float> values, const SurfaceAtlas& surface,
                 ImageU8& marked) {
  const TileGrid& grid = surface.grid();
  for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
    const TexelIndex t = tile * TileGrid::kTileTexels + i;
    const int triangle = surface.triangle(t);
    if (triangle < 0 || static_cast<std::size_t>(surface.object(triangle)) != object) continue;
    if (static_cast<double>(values[i]) >= kCrackValue) marked.at(grid.x(t), grid.y(t)) = 255;
  }
}

/// @throws InvalidInput if a picture is not over the object's square of UVs.
void check_crack_maps(const Scene& scene, const StartExpression& expression, const std::vector<std::string>& names) {
  for (const SceneMap& map : scene.maps) {
    const bool is_named = std::find(names.begin(), names.end(), map.name) != names.end();
    if (!is_named || expression.object >= map.images.size()) continue;
    const ImageF& image = map.images[expression.object];
    if (image.width() == image.height()) continue;
    throw InvalidInput(expression.subject + ": the picture of '" + map.name + "' is " +
                       size_text(image.width(), image.height()) +
                       " pixels; a map of cracks is square, over the object's UVs");
  }
}

}  // namespace

std::vector<std::string> layer_map_names(const Scene& scene, std::size_t object, std::size_t layer) {
  std::vector<std::string> names;
  for (const LayerQuantity quantity : quantities_of(scene.objects[object].layers[layer])) {
    const StartExpression expression = layer_expression(scene, object, layer, quantity);
    const std::vector<std::string> own = start_names(scene, expression);
    if (quantity == LayerQuantity::Cracks) check_crack_maps(scene, expression, own);
    names.insert(names.end(), own.begin(), own.end());
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
        if (quantity == LayerQuantity::Cracks)
          check_crack_maps(scene, expressions.back(), start_names(scene, expressions.back()));
        laid.push_back({static_cast<int>(l), quantity});
      }
    }
  }
  const TileGrid& grid = layers.surface().grid();
  std::array<ImageU8, kMaxLayers> marked;  // By layer.
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
          case LayerQuantity::Cracks: {
            ImageU8& own = marked[static_cast<std::size_t>(laid[i].layer)];
            if (own.empty()) own = ImageU8(grid.width, grid.height);
            return mark_cracks(expressions[i].object, tile, values, layers.surface(), own);
          }
        }
      },
      control);
  lay_tension_axes(scene, scene_mesh, layers);
  for (std::size_t l = 1; l < marked.size(); ++l) {
    if (!marked[l].empty()) lay_cracks(marked[l], static_cast<int>(l), layers);
  }
  layers.renew_tops(control);
  layers.begin_accounts(control);
}

void replace_layers(LayerAtlas&& restored, LayerAtlas& layers) {
  restored.strength() = std::move(layers.strength());
  for (int l = 1; l < layers.num_layers(); ++l) restored.tension_axes(l) = std::move(layers.tension_axes(l));
  layers = std::move(restored);
}

}  // namespace patinate::simulation
