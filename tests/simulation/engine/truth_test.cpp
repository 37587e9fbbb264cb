// Whole simulations against closed forms.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "patinate/simulation/engine.h"
#include "simulation/tracing/gammatons.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/simulation/tracing/chi_square.h"
#include "tests/simulation/tracing/tracing_scene.h"
#include "tests/support/long_scene.h"
#include "tests/support/meshes.h"

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
        hits[surface.triangle(t)] +=
            std::round(static_cast<double>(map.at(surface.grid().x(t), surface.grid().y(t))) * surface.area_mm2(t));
    }
    double total = 0.0, total_shadow = 0.0;
    for (std::size_t t = 0; t < hits.size(); ++t) {
      const auto p = [&](std::size_t k) { return mesh.positions[mesh.triangles[t][k]]; };
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

/// A level plate in rain that stays, or one that it runs down.
Scene plate_in_rain(int resolution, double slope_deg) {
  Scene scene = scene_with(testing_support::unit_plane(100.0, 8), resolution);
  scene.objects[0].rotate_deg = Vec3(slope_deg - 90.0, 0, 0);
  scene.gravity_mm_s2 = Vec3(0, -9810, 0);
  scene.emitters[0] = {.name = "rain",
                       .shape = EmitterShape::Sky,
                       .direction = Vec3(0, -1, 0),
                       .speed_mm_s = 1000,
                       .gammatons = 500,
                       .carries = {0.5}};
  scene.behavior = {.bounce = 0.0,
                    .floating = slope_deg > 0.0 ? 0.9 : 0.0,
                    .absorb = slope_deg > 0.0 ? 0.1 : 1.0,
                    .deceleration_bounce = 0.0,
                    .deceleration_float = 0.2};
  scene.exchange = {.ratio = 0.8, .rates = {0.2}, .splat_mm = 3.0};
  return scene;
}

TEST(SimulationTruths, WhatIsAbsorbedOrRestsIsOnTheSurface) {
  for (const double slope : {0.0, 30.0}) {
    for (const bool deposit : {true, false}) {
      Scene scene = plate_in_rain(128, slope);
      scene.exchange.deposit = deposit;
      Simulation simulation(scene);
      for (int i = 0; i < 30; ++i) simulation.step();
      EXPECT_TRUE(simulation.ledger().balances());
      EXPECT_EQ(simulation.audit(), "");
      const MassAccount& water = simulation.ledger().account(0);
      const double lost = water.absorbed.value() + water.rested.value();
      if (deposit) {
        // Less than a quantum of a texel for each of some 30 parts.
        EXPECT_LT(lost, 30.0 * 300.0 * static_cast<double>(simulation.counters().emitted));
        EXPECT_LT(lost, 1e-3 * water.on_surfaces.value());
      } else {
        EXPECT_GT(lost, 0.2 * water.emitted.value());
      }
    }
  }
}

TEST(SimulationTruths, ResolutionChangesNothingButSharpness) {
  // Drops are the same at the same places; what differs is how finely they are shown, and the rounding to quanta.
  constexpr int kCoarsest = 128, kIterations = 40;
  for (const double slope : {0.0, 30.0}) {
    std::vector<double> coarse;
    for (const int resolution : {128, 256, 512}) {
      Simulation simulation(plate_in_rain(resolution, slope));
      for (int i = 0; i < kIterations; ++i) simulation.step();
      const ImageF amounts = simulation.amounts(0);
      const int side = resolution / kCoarsest;
      std::vector<double> blurred(std::size_t{kCoarsest} * kCoarsest, 0.0);
      double mean = 0.0;
      for (int y = 0; y < resolution; ++y) {
        for (int x = 0; x < resolution; ++x) {
          const double share = static_cast<double>(amounts.at(x, y)) / (side * side);
          blurred[y / side * kCoarsest + x / side] += share;
          mean += share / (kCoarsest * kCoarsest);
        }
      }
      if (resolution == kCoarsest) {
        coarse = blurred;
        continue;
      }
      double coarse_mean = 0.0, variance = 0.0, difference = 0.0;
      const double n = static_cast<double>(coarse.size());
      for (const double a : coarse) coarse_mean += a / n;
      for (std::size_t i = 0; i < coarse.size(); ++i) {
        variance += (coarse[i] - coarse_mean) * (coarse[i] - coarse_mean) / n;
        difference += (blurred[i] - coarse[i]) * (blurred[i] - coarse[i]) / n;
      }
      // A level plate keeps all that falls on it. On a slope less is picked up again where a drop's middle stands out
      // of its splat more sharply: of the second order.
      EXPECT_NEAR(mean / coarse_mean, 1.0, slope == 0.0 ? 1e-3 : 0.01) << resolution;
      // At 128 a drop's middle is where its texel's is: displaced by a uniform error of variance 1/12 texel^2 each way,
      // against a standard deviation of 0.64 texels that a drop has. Independent counts would differ by sqrt(2).
      EXPECT_LT(std::sqrt(difference / variance), 0.5) << resolution << " at a slope of " << slope;
    }
  }
}

/// Drops that run over a line across a slope, by where they do.
std::vector<double> crossings(double wet_attraction) {
  constexpr int kBins = 40;  // half a rivulet each
  Scene scene = plate_in_rain(256, 60.0);
  scene.behavior = {
      .bounce = 0.0, .floating = 0.99, .absorb = 0.01, .deceleration_bounce = 0.0, .deceleration_float = 0.2};
  scene.tracing.lobe_exponent_float = 2000;
  scene.tracing.rest_speed_mm_s = 0.0;
  scene.tracing.wet_attraction = wet_attraction;
  scene.tracing.rivulet_mm = 4.0;
  scene.exchange.splat_mm = 1.5;
  scene.time_per_iteration = 1.0;
  scene.rules.push_back({.name = "evaporation", .driver = "water", .rate = 0.02, .products = {}, .reactants = {1.0}});
  Simulation simulation(scene);
  std::vector<double> counts(kBins, 0.0);
  std::vector<double> before;
  std::vector<std::uint32_t> births;
  constexpr double kLine = 0.75;  // of the way down
  for (int i = 0; i < 500; ++i) {
    simulation.step();
    const Gammatons& g = simulation.gammatons();
    double low = 1e30, high = -1e30;
    for (const Vec3& p : simulation.mesh().positions) {
      low = std::min(low, p.y());
      high = std::max(high, p.y());
    }
    std::vector<double> now(g.size());
    for (std::size_t k = 0; k < g.size(); ++k) {
      now[k] = g.state[k] == GammatonState::Floating ? (high - g.position[k].y()) / (high - low) : -1.0;
      if (before.empty() || births[k] != g.num_births[k] || before[k] < 0.0 || before[k] >= kLine || now[k] < kLine)
        continue;
      const double x = (g.position[k].x() - 10.0) / 80.0;  // without the plate's ends
      if (x >= 0.0 && x < 1.0) counts[static_cast<std::size_t>(x * kBins)] += 1.0;
    }
    before = now;
    births = g.num_births;
  }
  return counts;
}

TEST(SimulationTruths, WetPathsGatherDropsAndWithoutThemTheyComeAsByChance) {
  const auto dispersion = [](const std::vector<double>& counts) {
    double mean = 0.0, chi_square = 0.0;
    for (const double c : counts) mean += c / static_cast<double>(counts.size());
    for (const double c : counts) chi_square += (c - mean) * (c - mean) / mean;
    EXPECT_GT(mean, 30.0);
    return chi_square;
  };
  // Independent drops: chi-square of as many degrees of freedom as there are bins but one.
  EXPECT_LT(dispersion(crossings(0.0)), chi_square_limit(39));
  const double little = dispersion(crossings(0.1)), much = dispersion(crossings(0.3));
  EXPECT_GT(much, chi_square_limit(39)) << "no chance";
  EXPECT_GT(much, little);
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
