#include "simulation/rules/initial_amounts.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/expression_program.h"
#include "patinate/core/error.h"
#include "simulation/rules/scene_maps.h"

namespace patinate::simulation {

namespace {

/// Maps that are there at the start.
std::vector<std::string> start_names(const Scene& scene) {
  std::vector<std::string> names = map_names(scene);
  names.insert(names.end(), built_in_maps().begin(), built_in_maps().end());
  names.emplace_back("slope");
  return names;
}

Expression initial_expression(const Scene& scene, std::size_t object, int material) {
  const std::vector<std::string> names = start_names(scene);
  const auto m = static_cast<std::size_t>(material);
  try {
    return parse_expression(
        scene.objects[object].initial[m],
        {.subject = "initial " + scene.materials[m] + " of object '" + scene.objects[object].name + "'",
         .name = "map",
         .names = names,
         .has_files = false});
  } catch (const ParseError& e) {
    throw InvalidInput(e.what());
  }
}

/// An expression with its maps.
struct InitialAmount {
  std::size_t object = 0;
  int material = 0;
  ExpressionProgram program;
};

struct alignas(64) Block {
  std::array<float, TileGrid::kTileTexels> values;
};

/// Where texels of the object are, amounts become what the program says.
void lay_tile(const InitialAmount& amount, TileIndex tile, std::span<const float> values, MaterialAtlas& atlas,
              LaidAmounts& laid) {
  const SurfaceAtlas& surface = atlas.surface();
  const auto m = static_cast<std::size_t>(amount.material);
  std::array<std::uint16_t, TileGrid::kTileTexels> before;
  atlas.read_tile(amount.material, tile, before);
  std::array<std::uint16_t, TileGrid::kTileTexels> after = before;
  for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
    const TexelIndex t = tile * TileGrid::kTileTexels + i;
    const int triangle = surface.triangle(t);
    if (triangle < 0 || static_cast<std::size_t>(surface.object(triangle)) != amount.object) continue;
    const double value = std::clamp(static_cast<double>(values[i]), 0.0, kMostAmount);
    after[i] = static_cast<std::uint16_t>(std::floor(value * kAmountOne + 0.5));
    const std::int64_t change = (std::int64_t{after[i]} - before[i]) * surface.weight(t);
    (change > 0 ? laid.more : laid.less)[m] += std::abs(change);
  }
  if (after == before) return;
  const std::span<std::uint16_t> stored = atlas.writable_tile(amount.material, tile);
  std::copy(after.begin(), after.end(), stored.begin());
}

}  // namespace

std::vector<std::string> initial_names(const Scene& scene, std::size_t object, int material) {
  std::vector<std::string> names;
  for (const ExpressionName& name : initial_expression(scene, object, material).names) names.push_back(name.text);
  return names;
}

LaidAmounts lay_initial_amounts(const Scene& scene, const SceneMesh& scene_mesh, MaterialAtlas& atlas,
                                const RunControl& control) {
  std::vector<Expression> expressions;
  std::vector<InitialAmount> amounts;
  std::vector<std::string> names;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
      if (scene.objects[o].initial[m].empty()) continue;
      amounts.push_back({.object = o, .material = static_cast<int>(m), .program = {}});
      expressions.push_back(initial_expression(scene, o, static_cast<int>(m)));
      for (const ExpressionName& name : expressions.back().names) {
        if (std::find(names.begin(), names.end(), name.text) == names.end()) names.push_back(name.text);
      }
    }
  }
  LaidAmounts laid;
  if (amounts.empty()) return laid;
  const std::vector<SurfaceParameter> maps = make_parameters(names, scene, scene_mesh, atlas.surface(), control);
  std::size_t num_slots = std::max<std::size_t>(1, maps.size());
  for (std::size_t i = 0; i < amounts.size(); ++i) {
    const auto slot_of = [&](const ExpressionName& name) {
      return static_cast<int>(std::find(names.begin(), names.end(), name.text) - names.begin());
    };
    amounts[i].program = compile_expression(expressions[i], slot_of, static_cast<int>(maps.size()));
    num_slots = std::max(num_slots, static_cast<std::size_t>(amounts[i].program.num_slots));
  }
  std::vector<Block> slots(num_slots);
  for (TileIndex tile = 0; tile < atlas.surface().grid().num_tiles(); ++tile) {
    for (std::size_t k = 0; k < maps.size(); ++k) load_parameter(maps[k], tile, slots[k].values.data());
    for (const InitialAmount& amount : amounts) {
      for (const auto& constant : amount.program.constants) slots[constant.slot].values.fill(constant.value);
      run_expression(amount.program, slots[0].values.data(), instruction_set());
      lay_tile(amount, tile, slots[amount.program.result].values, atlas, laid);
    }
  }
  return laid;
}

}  // namespace patinate::simulation
