#include <algorithm>
#include <numeric>

#include "libcommon/atlas/texel_map.h"
#include "libcommon/controls/control_kinds.h"
#include "simulation/engine_state.h"

namespace patinate {

namespace {

/// What drivers ask for beside materials: slope from the triangles, everything else as the control map of that name, in [0, 1].
std::vector<SurfaceParameter> make_parameters(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface, const RunControl& control) {
  std::vector<std::string> names;
  for (const Rule& rule : scene.rules) {
    for (const std::string& name : parameters_of(rule, scene.materials)) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
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
  return std::make_unique<RuleEngine>(scene.rules, scene.materials, surface, scene.time_per_iteration, scene.seed,
                                      make_parameters(scene, scene_mesh, surface, quiet));
}

void Simulation::State::apply_rules(std::span<const TileIndex> touched, const RunControl& control) {
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

}  // namespace patinate
