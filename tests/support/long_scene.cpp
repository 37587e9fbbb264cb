#include "tests/support/long_scene.h"

#include "tests/support/meshes.h"

namespace patinate::testing_support {

simulation::Scene long_scene(double ratio) {
  simulation::Scene scene;
  scene.materials = {"water", "metal", "rust", "dirt"};
  scene.appearance.resize(4);
  scene.resolution = 64;
  simulation::SceneObject object;
  object.name = "plate";
  object.mesh = quilt_plane(100.0, 4);
  object.preset.amounts = {0.0, 1.0, 0.0, 0.5};
  object.rotate_deg = Vec3(-60, 0, 0);
  scene.objects.push_back(object);
  simulation::Emitter rain;
  rain.name = "rain";
  rain.shape = simulation::EmitterShape::Rectangle;
  rain.position_mm = Vec3(50, 120, -20);
  rain.size_mm = {90, 40};
  rain.gammatons = 3;
  rain.speed_mm_s = 3000;
  rain.carries = {0.8, 0.0, 0.0, 0.3};
  scene.emitters.push_back(rain);
  scene.exchange = {.ratio = ratio, .rates = {0.4, 1.0 / 4096, 0.02, 1.0}};
  simulation::Rule rust{.name = "rust", .driver = "min(water, metal)", .rate = 0.5};
  rust.products[2] = 1.0;
  rust.reactants[1] = 1.0;
  simulation::Rule dry{.name = "evaporation", .driver = "water", .rate = 0.3};
  dry.reactants[0] = 1.0;
  scene.rules = {rust, dry};
  scene.time_per_iteration = 0.01;
  return scene;
}

}  // namespace patinate::testing_support
