// Whole simulations against closed forms.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "patinate/simulation/engine.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/simulation/tracing/chi_square.h"
#include "tests/simulation/tracing/tracing_scene.h"
#include "tests/support/long_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::chi_square_limit;
using testing_support::make_icosphere;
using testing_support::scene_with;
using testing_support::with_any_uvs;

/// A ball of 320 facets in parallel rain that stays where it falls. Each facet is a chart of its own.
Scene ball_in_rain(EmitterShape shape, const Vec3& direction) {
  Scene scene = scene_with(with_any_uvs(make_icosphere(50.0, 2)), 512);
  scene.emitters[0] = {.name = "rain",
                       .shape = shape,
                       .position_mm = -100.0 * direction,
                       .direction = direction,
                       .size_mm = {130, 130},
                       .gammatons = 50000};
  return scene;
}

TEST(SimulationTruths, HitsOfAFacetGoByItsAreaAndItsCosine) {
  const Vec3 slanted = Vec3(0.5, -1, 0.2).normalized();
  for (const auto& [shape, direction] : {std::pair{EmitterShape::Rectangle, Vec3(0, -1, 0)},
                                         {EmitterShape::Rectangle, slanted},
                                         {EmitterShape::Sky, slanted}}) {
    Simulation simulation(ball_in_rain(shape, direction), {.parameter_maps = {"hits"}});
    for (int i = 0; i < 4; ++i) simulation.step();
    const SurfaceAtlas& surface = simulation.atlas().surface();
    const ImageF map = simulation.parameter_map("hits").values;
    const Mesh& mesh = simulation.mesh();
    std::vector<double> hits(static_cast<std::size_t>(mesh.num_triangles()), 0.0), shadow(hits.size(), 0.0);
    for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
      if (surface.is_covered(t))
        hits[static_cast<std::size_t>(surface.triangle(t))] +=
            std::round(static_cast<double>(map.at(surface.grid().x(t), surface.grid().y(t))) * surface.area_mm2(t));
    }
    double total = 0.0, total_shadow = 0.0;
    for (std::size_t t = 0; t < hits.size(); ++t) {
      const auto p = [&](std::size_t k) { return mesh.positions[static_cast<std::size_t>(mesh.triangles[t][k])]; };
      shadow[t] = -0.5 * (p(1) - p(0)).cross(p(2) - p(0)).dot(direction);  // area * cosine, mm2
      if (shadow[t] <= 0.0) {
        EXPECT_EQ(hits[t], 0.0) << "a facet that looks away";
        continue;
      }
      total += hits[t];
      total_shadow += shadow[t];
    }
    double chi_square = 0.0, freedom = -1.0;
    for (std::size_t t = 0; t < hits.size(); ++t) {
      const double expected = total / total_shadow * shadow[t];
      if (expected < 20.0) continue;  // seen edge-on
      chi_square += (hits[t] - expected) * (hits[t] - expected) / expected;
      freedom += 1.0;
    }
    EXPECT_GT(freedom, 140.0);
    EXPECT_LT(chi_square, chi_square_limit(freedom));
    // How many, too: of a rectangle's drops, the share that the ball's shadow has of it.
    if (shape != EmitterShape::Rectangle) continue;
    const double expected = 4.0 * 50000.0 * total_shadow / (130.0 * 130.0);
    EXPECT_NEAR(total, expected, 4.0 * std::sqrt(expected));
  }
}

TEST(SimulationTruths, NoQuantumIsLostInAHundredThousandIterations) {
  // A few drops on a small plate for very long, with rates from the smallest to all at once; `simulation_benchmark
  // mass_balance` does a million.
  RunControl one_thread;  // there is too little to share
  one_thread.num_threads = 1;
  for (const double ratio : {0.0, 0.37, 0.5, 1.0}) {
    Simulation simulation(testing_support::long_scene(ratio));
    for (int i = 0; i < 25'000; ++i) simulation.step(one_thread);
    EXPECT_TRUE(simulation.ledger().balances()) << ratio;
    EXPECT_EQ(simulation.audit(), "") << ratio;
    EXPECT_GT(simulation.counters().contacts, 20'000) << ratio;
  }
}

}  // namespace
}  // namespace patinate::simulation
