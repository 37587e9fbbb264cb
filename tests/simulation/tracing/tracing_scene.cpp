#include "tests/simulation/tracing/tracing_scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace patinate::testing_support {

simulation::Scene scene_with(Mesh mesh, int resolution) {
  simulation::Scene scene;
  scene.materials = {"water"};
  scene.appearance.resize(1);
  scene.resolution = resolution;
  simulation::SceneObject object;
  object.name = "object";
  object.mesh = std::move(mesh);
  scene.objects.push_back(std::move(object));
  simulation::Emitter rain;
  rain.name = "rain";
  rain.shape = simulation::EmitterShape::Point;
  rain.gammatons = 1000;
  scene.emitters.push_back(rain);
  scene.behavior = {
      .bounce = 0.0, .floating = 0.0, .absorb = 1.0, .deceleration_bounce = 0.0, .deceleration_float = 0.0};
  scene.gravity_mm_s2 = Vec3::Zero();
  return scene;
}

Mesh with_any_uvs(Mesh mesh) {
  const int side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(mesh.num_triangles()))));
  mesh.uvs.clear();
  mesh.uv_triangles.clear();
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const double u = static_cast<double>(t % side) / side, v = static_cast<double>(t / side) / side, s = 0.9 / side;
    const int first = static_cast<int>(mesh.uvs.size());
    mesh.uvs.insert(mesh.uvs.end(), {{u, v}, {u + s, v}, {u, v + s}});
    mesh.uv_triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

TracedScene::TracedScene(simulation::Scene from)
    : scene(std::move(from)),
      mesh(simulation::make_scene_mesh(scene)),
      surface(mesh, scene.resolution),
      tracer(mesh, surface),
      gammatons(simulation::make_gammatons(scene)) {}

void TracedScene::trace(int num_threads) {
  RunControl control;
  control.num_threads = num_threads;
  tracer.trace(gammatons, scene, iteration, traced, control);
}

void TracedScene::respond(int num_threads) {
  RunControl control;
  control.num_threads = num_threads;
  tracer.respond(gammatons, scene, iteration, responded, nullptr, control);
  for (const simulation::TraceCounters* c : {&traced.counters, &responded.counters}) {
    sum.segments += c->segments;
    sum.contacts += c->contacts;
    sum.emitted += c->emitted;
    sum.absorbed += c->absorbed;
    sum.left += c->left;
    sum.rested += c->rested;
  }
  sum.alive = responded.counters.alive;
  ++iteration;
  ASSERT_EQ(sum.emitted, sum.absorbed + sum.left + sum.rested + sum.alive);
  ASSERT_EQ(traced.counters.emitted, static_cast<std::int64_t>(traced.born.size()));
}

void TracedScene::step(int num_threads) {
  trace(num_threads);
  respond(num_threads);
}

}  // namespace patinate::testing_support
