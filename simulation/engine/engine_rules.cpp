#include <algorithm>
#include <numeric>

#include "patinate/atlas/texel_map.h"
#include "patinate/controls/control_kinds.h"
#include "simulation/engine/engine_state.h"

namespace patinate::simulation {

namespace {

/// What drivers ask for beside materials.
std::vector<std::string> parameter_names(std::span<const Rule> rules, std::span<const std::string> materials) {
  std::vector<std::string> names;
  for (const Rule& rule : rules) {
    for (const std::string& name : parameters_of(rule, materials)) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

/// Slope from the mesh's normals, everything else as the control map of that name, in [0, 1].
std::vector<SurfaceParameter> make_parameters(std::span<const std::string> names, const Scene& scene,
                                              const SceneMesh& scene_mesh, const SurfaceAtlas& surface,
                                              const RunControl& control) {
  std::vector<SurfaceParameter> parameters;
  if (names.empty()) return parameters;
  const double gravity = scene.gravity_mm_s2.norm();
  const Vec3 up = gravity > 0.0 ? Vec3(-scene.gravity_mm_s2 / gravity) : Vec3::UnitY();
  std::unique_ptr<const TexelMap> map;
  for (const std::string& name : names) {
    if (name == "slope") {
      parameters.push_back(slope_parameter(scene_mesh, surface, up));
      continue;
    }
    if (!map) map = std::make_unique<const TexelMap>(scene_mesh.mesh, scene.resolution, scene.resolution, control);
    parameters.push_back(map_parameter(name, make_control(name, *map, {}, control).values, surface));
  }
  return parameters;
}

}  // namespace

std::unique_ptr<RuleEngine> Simulation::State::make_rules(const RunControl& control) const {
  RunControl quiet = control;
  quiet.on_progress = {};
  return std::make_unique<RuleEngine>(
      scene.rules, scene.materials, surface, scene.time_per_iteration, scene.seed,
      make_parameters(parameter_names(scene.rules, scene.materials), scene, scene_mesh, surface, quiet));
}

void Simulation::State::set_rules(std::span<const Rule> changed) {
  std::vector<std::string> missing = parameter_names(changed, scene.materials);
  std::erase_if(missing, [&](const std::string& name) { return rules->has_parameter(name); });
  std::vector<SurfaceParameter> more;
  if (!missing.empty()) more = make_parameters(missing, scene, scene_mesh, surface, {});
  rules->set_rules(changed, scene.materials, std::move(more));
}

void Simulation::State::apply_rules(std::span<const TileIndex> touched, const RunControl& control) {
  renew_rules(control);
  rules->wake(touched);
  const RuleReport report = rules->step(iteration, atlas, control);
  ledger.add_rules(report.made, report.used);
  mark(report.dirty_tiles);
}

void Simulation::State::wake_everything() {
  std::vector<TileIndex> all(surface.grid().num_tiles());
  std::iota(all.begin(), all.end(), TileIndex{0});
  rules->wake(all);
  std::fill(changed_in.begin(), changed_in.end(), static_cast<std::int32_t>(iteration));
}

}  // namespace patinate::simulation
