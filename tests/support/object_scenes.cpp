#include "tests/support/object_scenes.h"

#include "libcommon/core/files.h"
#include "patinate/datasets/objects.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/simulation/scene_io.h"
#include "tests/support/plate_scene.h"
#include "tests/support/temp_folder.h"

namespace patinate::testing_support {

using simulation::Scene;

Scene wall_scene(int resolution) {
  const TempFolder folder;
  write_obj(folder / "mesh.obj", datasets::ledge());
  write_atomically(folder / "scene.json", datasets::ledge_scene({}, "mesh.obj"));
  Scene scene = simulation::read_scene(folder / "scene.json").scene;
  scene.resolution = resolution;
  return scene;
}

Scene urn_scene(int resolution) {
  Scene scene = plate_scene(resolution);
  scene.objects[0].name = "urn";
  scene.objects[0].mesh = datasets::sculpture({.resolution = 48});
  scene.objects[0].rotate_deg = Vec3(0, 0, 0);
  scene.gravity_mm_s2 = Vec3(0, -9810, 0);
  simulation::Emitter& rain = scene.emitters[0];
  rain.direction = Vec3(0.2, -1, 0.1).normalized();
  rain.gammatons = 1500;
  simulation::Emitter splash = rain;
  splash.name = "splash";
  splash.shape = simulation::EmitterShape::Disk;
  splash.position_mm = Vec3(0, -2, 60);
  splash.direction = Vec3(0, 1, -0.4).normalized();
  splash.size_mm = {60, 60};
  splash.spread_deg = 30.0;
  splash.speed_mm_s = 1200.0;
  splash.gammatons = 300;
  scene.emitters.push_back(splash);
  scene.behavior = {
      .bounce = 0.2, .floating = 0.7, .absorb = 0.1, .deceleration_bounce = 0.3, .deceleration_float = 0.2};
  scene.tracing.wet_material = scene.materials[0];
  scene.tracing.wet_attraction = 1.0;
  scene.tracing.rivulet_mm = 4.0;
  scene.rules.push_back(rust_rule(0.5));
  scene.rules.push_back({.name = "dry", .driver = "water", .rate = 0.2, .products = {}, .reactants = {1.0}});
  scene.exchange.rates = {0.5, 0.0, 0.05};
  scene.exchange.splat_mm = 2.0;
  return scene;
}

}  // namespace patinate::testing_support
