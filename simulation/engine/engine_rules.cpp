#include <algorithm>

#include "simulation/engine/engine_state.h"
#include "simulation/rules/scene_maps.h"

namespace patinate::simulation {

namespace {

/// Parameters that drivers ask for beside materials.
std::vector<std::string> parameter_names(std::span<const Rule> rules, const Scene& scene) {
  const std::vector<std::string> maps = map_names(scene), layers = layer_names(scene);
  std::vector<std::string> names;
  for (const Rule& rule : rules) {
    for (const std::string& name : parameters_of(rule, scene.materials, maps, layers)) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

}  // namespace

std::unique_ptr<RuleEngine> Simulation::State::make_rules(const RunControl& control) const {
  const RunControl quiet = control.silent();
  auto engine = std::make_unique<RuleEngine>(
      scene.rules, scene.materials, surface, scene.time_per_iteration, scene.seed,
      make_parameters(parameter_names(scene.rules, scene), scene, scene_mesh, surface, quiet), instruction_set(),
      layers.get());
  engine->set_weather(scene.weather);
  return engine;
}

void Simulation::State::set_rules(std::span<const Rule> changed) {
  std::vector<std::string> missing = parameter_names(changed, scene);
  std::erase_if(missing, [&](const std::string& name) { return rules->has_parameter(name); });
  std::vector<SurfaceParameter> more;
  if (!missing.empty()) more = make_parameters(missing, scene, scene_mesh, surface, {});
  rules->set_rules(changed, scene.materials, std::move(more));
}

void Simulation::State::apply_rules(const RunControl& control) {
  renew_rules(control);
  const RuleReport report = rules->step(iteration, atlas, control);
  ledger.add_rules(report.made, report.used);
  mark(report.dirty_tiles);
}

void Simulation::State::wake_everything() {
  rules->wake_everything();
  std::fill(changed_in.begin(), changed_in.end(), static_cast<std::int32_t>(iteration));
}

}  // namespace patinate::simulation
