#include "simulation/rules/rule_io.h"
#include "simulation/rules/rules.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

namespace {

const std::vector<std::string> kMaterials{"water", "metal", "rust", "dirt", "organic"};

simulation::SurfaceAtlas triangle_surface() {
  simulation::Scene scene;
  simulation::SceneObject object;
  object.name = "triangle";
  object.mesh.positions = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}};
  object.mesh.triangles = {{0, 1, 2}};
  object.mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  object.mesh.uv_triangles = {{0, 1, 2}};
  object.mesh.triangle_surface = {0};
  object.mesh.surfaces.resize(1);
  scene.objects.push_back(std::move(object));
  return simulation::SurfaceAtlas(simulation::make_scene_mesh(scene), 32);
}

}  // namespace

/// Whatever a rule says, amounts change by what it reports.
PATINATE_FUZZ_TARGET(rule) {
  const std::vector<simulation::Rule> rules{
      simulation::resolve_rule(simulation::load_rule(fuzz::fuzz_file("rule.json", bytes)), kMaterials)};
  static const simulation::SurfaceAtlas surface = triangle_surface();
  simulation::MaterialAtlas atlas(surface, static_cast<int>(kMaterials.size()), {{9000, 16384, 65535, 1, 0}});
  std::vector<simulation::SurfaceParameter> parameters;
  for (const std::string& name : simulation::parameters_of(rules[0], kMaterials)) {
    parameters.push_back({.name = name, .values = std::vector<float>(surface.grid().num_texels(), 0.25F)});
  }
  simulation::RuleEngine engine(rules, kMaterials, surface, 0.5, 1, parameters);
  RunControl control;
  control.num_threads = 1;
  for (int i = 0; i < 9; ++i) {
    std::array<std::int64_t, simulation::kMaxMaterials> before{};
    for (std::size_t m = 0; m < kMaterials.size(); ++m) before[m] = atlas.mass(static_cast<int>(m), control);
    const simulation::RuleReport report = engine.step(i, atlas, control);
    for (std::size_t m = 0; m < kMaterials.size(); ++m) {
      fuzz::require(report.made[m] >= 0 && report.used[m] >= 0, "what is made and used is not below 0");
      fuzz::require(atlas.mass(static_cast<int>(m), control) == before[m] + report.made[m] - report.used[m],
                    "amounts change by what is reported");
    }
  }
}
