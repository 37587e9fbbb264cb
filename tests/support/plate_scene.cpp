#include "tests/support/plate_scene.h"

#include "tests/support/meshes.h"

namespace patinate::testing_support {

simulation::Scene plate_scene(int resolution) {
  simulation::Scene scene;
  scene.materials = {"water", "metal", "rust"};
  scene.appearance.resize(3);
  scene.appearance[2].color.color = Vec3(0.2, 0.06, 0.02);
  scene.resolution = resolution;
  simulation::SceneObject object;
  object.name = "plate";
  object.mesh = unit_plane(100.0);
  object.preset.amounts[1] = 1.0;
  object.rotate_deg = Vec3(-60, 0, 0);
  scene.objects.push_back(object);
  simulation::Emitter rain;
  rain.name = "rain";
  rain.shape = simulation::EmitterShape::Sky;
  rain.gammatons = 200;
  rain.carries[0] = 0.8;
  scene.emitters.push_back(rain);
  scene.exchange.rates[0] = 0.4;
  scene.time_per_iteration = 0.05;
  return scene;
}

simulation::Rule rust_rule(double alpha) {
  simulation::Rule rule{.name = "rust", .driver = "min(water, metal)", .rate = alpha};
  rule.products[2] = 1.0;
  return rule;
}

}  // namespace patinate::testing_support
