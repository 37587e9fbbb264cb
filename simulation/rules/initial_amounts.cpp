#include "simulation/rules/initial_amounts.h"

#include <algorithm>
#include <cmath>

#include "simulation/rules/start_values.h"

namespace patinate::simulation {

namespace {

StartExpression initial_expression(const Scene& scene, std::size_t object, std::size_t material) {
  return {.object = object,
          .text = scene.objects[object].initial[material],
          .subject = "initial " + scene.materials[material] + " of object '" + scene.objects[object].name + "'"};
}

/// Where texels of the object are, amounts become what the values say.
void lay_tile(std::size_t object, int material, TileIndex tile, std::span<const float> values, MaterialAtlas& atlas,
              LaidAmounts& laid) {
  const SurfaceAtlas& surface = atlas.surface();
  const auto m = static_cast<std::size_t>(material);
  std::array<std::uint16_t, TileGrid::kTileTexels> before;
  atlas.read_tile(material, tile, before);
  std::array<std::uint16_t, TileGrid::kTileTexels> after = before;
  for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
    const TexelIndex t = tile * TileGrid::kTileTexels + i;
    const int triangle = surface.triangle(t);
    if (triangle < 0 || static_cast<std::size_t>(surface.object(triangle)) != object) continue;
    const double value = std::clamp(static_cast<double>(values[i]), 0.0, kMostAmount);
    after[i] = static_cast<std::uint16_t>(std::floor(value * kAmountOne + 0.5));
    const std::int64_t change = (std::int64_t{after[i]} - before[i]) * surface.weight(t);
    (change > 0 ? laid.more : laid.less)[m] += std::abs(change);
  }
  if (after == before) return;
  const std::span<std::uint16_t> stored = atlas.writable_tile(material, tile);
  std::copy(after.begin(), after.end(), stored.begin());
}

}  // namespace

std::vector<std::string> initial_names(const Scene& scene, std::size_t object, int material) {
  return start_names(scene, initial_expression(scene, object, static_cast<std::size_t>(material)));
}

LaidAmounts lay_initial_amounts(const Scene& scene, const SceneMesh& scene_mesh, MaterialAtlas& atlas,
                                const RunControl& control) {
  std::vector<StartExpression> expressions;
  std::vector<int> materials;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
      if (scene.objects[o].initial[m].empty()) continue;
      expressions.push_back(initial_expression(scene, o, m));
      materials.push_back(static_cast<int>(m));
    }
  }
  LaidAmounts laid;
  evaluate_at_start(
      scene, scene_mesh, atlas.surface(), expressions,
      [&](std::size_t i, TileIndex tile, std::span<const float> values) {
        lay_tile(expressions[i].object, materials[i], tile, values, atlas, laid);
      },
      control);
  return laid;
}

}  // namespace patinate::simulation
