/// \file
/// Small scenes for tests of gammatons.
#pragma once

#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/tracing/motion.h"

namespace patinate::testing_support {

/// One object, one emitter ("rain": a point at the origin looking down, 1000 gammatons), no gravity, all absorbed at
/// once.
[[nodiscard]] simulation::Scene scene_with(Mesh mesh, int resolution = 64);

/// Gives every triangle a part of the unit square of its own, so that any mesh has an atlas.
[[nodiscard]] Mesh with_any_uvs(Mesh mesh);

/// A scene and what is made from it.
struct TracedScene {
  explicit TracedScene(simulation::Scene from);
  simulation::Scene scene;
  simulation::SceneMesh mesh;
  simulation::SurfaceAtlas surface;
  simulation::GammatonTracer tracer;
  simulation::Gammatons gammatons;
  simulation::TraceResult traced, responded;
  simulation::TraceCounters sum;  ///< Over all steps; alive after the last.
  std::int64_t iteration = 0;

  /// trace() and respond(); checks the balance.
  void step(int num_threads = 0);
  void trace(int num_threads = 0);
  void respond(int num_threads = 0);
};

}  // namespace patinate::testing_support
