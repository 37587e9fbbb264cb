#include "simulation/rules/start_values.h"

#include <algorithm>
#include <array>

#include "libcommon/core/expression_program.h"
#include "patinate/core/error.h"
#include "simulation/rules/scene_maps.h"

namespace patinate::simulation {

namespace {

/// Maps that are there at the start.
std::vector<std::string> maps_at_start(const Scene& scene) {
  std::vector<std::string> names = map_names(scene);
  names.insert(names.end(), built_in_maps().begin(), built_in_maps().end());
  names.emplace_back("slope");
  return names;
}

Expression parsed(const Scene& scene, const StartExpression& expression) {
  const std::vector<std::string> names = maps_at_start(scene);
  try {
    return parse_expression(expression.text,
                            {.subject = expression.subject, .name = "map", .names = names, .has_files = false});
  } catch (const ParseError& e) {
    throw InvalidInput(e.what());
  }
}

struct alignas(64) ValueBlock {
  std::array<float, TileGrid::kTileTexels> values;
};

}  // namespace

std::vector<std::string> start_names(const Scene& scene, const StartExpression& expression) {
  std::vector<std::string> names;
  for (const ExpressionName& name : parsed(scene, expression).names) names.push_back(name.text);
  return names;
}

void evaluate_at_start(
    const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface,
    std::span<const StartExpression> expressions,
    const std::function<void(std::size_t index, TileIndex tile, std::span<const float> values)>& take,
    const RunControl& control) {
  if (expressions.empty()) return;
  std::vector<Expression> read;
  std::vector<std::string> names;
  for (const StartExpression& expression : expressions) {
    read.push_back(parsed(scene, expression));
    for (const ExpressionName& name : read.back().names) {
      if (std::find(names.begin(), names.end(), name.text) == names.end()) names.push_back(name.text);
    }
  }
  const std::vector<SurfaceParameter> maps = make_parameters(names, scene, scene_mesh, surface, control);
  const auto slot_of = [&](const ExpressionName& name) {
    return static_cast<int>(std::find(names.begin(), names.end(), name.text) - names.begin());
  };
  std::vector<ExpressionProgram> programs;
  std::size_t num_slots = std::max<std::size_t>(1, maps.size());
  for (const Expression& expression : read) {
    programs.push_back(compile_expression(expression, slot_of, static_cast<int>(maps.size())));
    num_slots = std::max(num_slots, static_cast<std::size_t>(programs.back().num_slots));
  }
  std::vector<ValueBlock> slots(num_slots);
  for (TileIndex tile = 0; tile < surface.grid().num_tiles(); ++tile) {
    for (std::size_t k = 0; k < maps.size(); ++k) load_parameter(maps[k], tile, slots[k].values.data());
    for (std::size_t i = 0; i < programs.size(); ++i) {
      for (const auto& constant : programs[i].constants) slots[constant.slot].values.fill(constant.value);
      run_expression(programs[i], slots[0].values.data(), instruction_set());
      take(i, tile, slots[programs[i].result].values);
    }
  }
}

}  // namespace patinate::simulation
