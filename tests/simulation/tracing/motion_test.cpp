#include "simulation/tracing/motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/core/hash.h"
#include "simulation/tracing/ray_tracer.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/simulation/tracing/chi_square.h"
#include "tests/simulation/tracing/tracing_scene.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace patinate::simulation {
namespace {

using testing_support::chi_square_limit;
using testing_support::make_cube;
using testing_support::make_icosphere;
using testing_support::make_patch;
using testing_support::scene_with;
using testing_support::TracedScene;
using testing_support::with_any_uvs;

constexpr double kGravity = 9810.0;

/// A square of the given side around the origin, tilted by `slope_deg`: down toward +x.
Mesh incline(double side, double slope_deg, int n = 8) {
  const double a = slope_deg * std::numbers::pi / 180.0;
  return make_patch(n, n, [&](double u, double v) {
    return Vec3((u - 0.5) * side * std::cos(a), -(u - 0.5) * side * std::sin(a), (0.5 - v) * side);
  });
}

TEST(GammatonTracer, ParallelRainHitsASphereByTheCosineAndNeverBehind) {
  Scene scene = scene_with(with_any_uvs(make_icosphere(50.0, 4)), 256);
  scene.emitters[0] = {.name = "rain",
                       .shape = EmitterShape::Disk,
                       .position_mm = {0, 100, 0},
                       .direction = {0, -1, 0},
                       .size_mm = {110, 110},
                       .gammatons = 200000};
  TracedScene run(scene);
  run.step();
  // Rings of equal projected area get equally many.
  constexpr std::size_t kRings = 20;
  std::array<double, kRings> hits{};
  double total = 0.0;
  for (std::size_t i = 0; i < run.gammatons.size(); ++i) {
    if (run.gammatons.triangle[i] < 0) continue;
    const Vec3 p = run.gammatons.position[i];
    EXPECT_GT(p.y(), -0.1);
    const double share = (p.x() * p.x() + p.z() * p.z()) / (49.0 * 49.0);  // inside the facets' outline
    if (share >= 1.0) continue;
    hits[static_cast<std::size_t>(share * kRings)] += 1.0;
    total += 1.0;
  }
  ASSERT_GT(total, 150000);
  double chi_square = 0.0;
  for (const double h : hits) chi_square += (h - total / kRings) * (h - total / kRings) / (total / kRings);
  EXPECT_LT(chi_square, chi_square_limit(kRings - 1));
}

TEST(GammatonTracer, InAClosedBoxHitsAreGeometric) {
  constexpr double kSurvival = 0.8;
  const std::uint32_t num_gammatons = testing_support::sample_count(100000u);
  Scene scene = scene_with(with_any_uvs(make_cube(100.0)));
  scene.emitters[0].position_mm = {50, 40, 60};
  scene.emitters[0].spread_deg = 180;
  scene.emitters[0].gammatons = num_gammatons;
  scene.behavior = {.bounce = kSurvival,
                    .floating = 0.0,
                    .absorb = 1.0 - kSurvival,
                    .deceleration_bounce = 0.0,
                    .deceleration_float = 0.0};
  TracedScene run(scene);
  run.trace();
  run.scene.emitters[0].is_on = false;
  std::vector<double> deaths;
  run.respond();
  deaths.push_back(static_cast<double>(run.responded.counters.absorbed));
  for (int k = 0; k < 100 && run.sum.alive > 0; ++k) {
    run.step();
    deaths.push_back(static_cast<double>(run.responded.counters.absorbed));
  }
  EXPECT_EQ(run.sum.left, 0) << "through a wall";
  EXPECT_EQ(run.sum.alive, 0);
  double n = num_gammatons, mean = 0.0, chi_square = 0.0, freedom = -1.0, rest = n, expected_rest = n;
  for (std::size_t k = 0; k < deaths.size(); ++k) {
    mean += static_cast<double>(k + 1) * deaths[k] / n;
    const double expected = n * (1.0 - kSurvival) * std::pow(kSurvival, static_cast<double>(k));
    if (expected < 20.0) continue;
    chi_square += (deaths[k] - expected) * (deaths[k] - expected) / expected;
    freedom += 1.0;
    rest -= deaths[k];
    expected_rest -= expected;
  }
  chi_square += (rest - expected_rest) * (rest - expected_rest) / expected_rest;
  EXPECT_LT(chi_square, chi_square_limit(freedom + 1.0));
  EXPECT_NEAR(mean, 1.0 / (1.0 - kSurvival), 4.0 * std::sqrt(kSurvival) / (1.0 - kSurvival) / std::sqrt(n));
}

TEST(GammatonTracer, NothingLeavesAClosedBoxInMillionsOfHits) {
  // Floating, bouncing and gravity, in a box whose corners and edges are all concave from within.
  Scene scene = scene_with(with_any_uvs(make_cube(20.0)));
  scene.emitters[0].position_mm = {10, 9, 11};
  scene.emitters[0].spread_deg = 180;
  scene.emitters[0].gammatons = 20000;
  scene.gravity_mm_s2 = {0, -kGravity, 0};
  scene.behavior = {
      .bounce = 0.5, .floating = 0.5, .absorb = 0.0, .deceleration_bounce = 0.1, .deceleration_float = 0.1};
  scene.tracing.rest_speed_mm_s = 0.0;
  TracedScene run(scene);
  for (int k = 0; k < 50; ++k) run.step();
  EXPECT_GT(run.sum.contacts, 500000);
  EXPECT_EQ(run.sum.left, 0);
  for (const Vec3& p : run.gammatons.position) {
    ASSERT_GE(p.minCoeff(), 0.0);
    ASSERT_LE(p.maxCoeff(), 20.0);
  }
}

TEST(GammatonTracer, FreeFallIsExactForAnyNumberOfPieces) {
  std::vector<double> landed;
  for (const int max_segments : {1, 3, 64}) {
    Scene scene = scene_with(incline(2000, 0));
    scene.emitters[0].position_mm = {0, 500, 0};
    scene.emitters[0].direction = Vec3(1, -1, 0).normalized();
    scene.emitters[0].speed_mm_s = 700;
    scene.emitters[0].gammatons = 1;
    scene.gravity_mm_s2 = {0, -kGravity, 0};
    scene.tracing.max_segments = max_segments;
    TracedScene run(scene);
    while (run.gammatons.state[0] != GammatonState::InContact) {
      run.trace();
      ASSERT_LT(++run.iteration, 1000);
    }
    const double v = 700.0 / std::sqrt(2.0);
    const double time = (-v + std::sqrt(v * v + 2.0 * kGravity * 500.0)) / kGravity;
    constexpr double kInside = 1e-3;  // contacts are moved into their triangle by a millionth of its size, 250 mm
    EXPECT_NEAR(run.gammatons.position[0].x(), v * time, kInside);
    EXPECT_NEAR(run.gammatons.velocity[0].y(), -(v + kGravity * time), 1e-6);
    EXPECT_NEAR(run.gammatons.velocity[0].x(), v, 1e-9);
  }
}

TEST(GammatonTracer, RouletteSharesAreThoseOfTheBehavior) {
  const std::uint32_t num_gammatons = testing_support::sample_count(100000u);
  Scene scene = scene_with(incline(1000, 0));
  scene.emitters[0].position_mm = {0, 100, 0};
  scene.emitters[0].gammatons = num_gammatons;
  scene.behavior = {
      .bounce = 0.2, .floating = 0.5, .absorb = 0.3, .deceleration_bounce = 0.0, .deceleration_float = 0.0};
  scene.tracing.rest_speed_mm_s = 0.0;
  TracedScene run(scene);
  run.step();
  double bounced = 0.0, floats = 0.0;
  for (const GammatonState s : run.gammatons.state) {
    bounced += s == GammatonState::Flying ? 1.0 : 0.0;
    floats += s == GammatonState::Floating ? 1.0 : 0.0;
  }
  const double n = num_gammatons;
  const auto four_sigma = [n](double p) { return 4.0 * std::sqrt(p * (1.0 - p) * n); };
  EXPECT_NEAR(bounced, 0.2 * n, four_sigma(0.2));
  EXPECT_NEAR(floats, 0.5 * n, four_sigma(0.5));
  EXPECT_NEAR(static_cast<double>(run.sum.absorbed), 0.3 * n, four_sigma(0.3));
}

TEST(GammatonTracer, DropsRunDownAnInclineAlongTheSteepestDescent) {
  constexpr double kSlope = 40.0;
  Scene scene = scene_with(incline(1000, kSlope, 40));
  scene.emitters[0].position_mm = {0, 200, 0};
  scene.emitters[0].gammatons = 200;
  scene.gravity_mm_s2 = {0, -kGravity, 0};
  scene.behavior = {
      .bounce = 0.0, .floating = 1.0, .absorb = 0.0, .deceleration_bounce = 0.0, .deceleration_float = 1.0};
  TracedScene run(scene);
  while (run.sum.contacts < 200) run.step();
  run.scene.emitters[0].is_on = false;
  const std::vector<Vec3> from = run.gammatons.position;
  for (int k = 0; k < 100; ++k) run.step();
  const double a = kSlope * std::numbers::pi / 180.0;
  const Vec3 downhill(std::cos(a), -std::sin(a), 0);
  const double travel = (run.gammatons.position[0] - from[0]).dot(downhill);
  EXPECT_NEAR(travel, 75.0, 5.8);  // epsilon / pull = 1 mm times [1/2, 1), a hundred times: 4 sigma
  for (std::size_t i = 0; i < from.size(); ++i) {
    // All speed is lost at every contact: nothing but gravity says where to.
    const Vec3 way = run.gammatons.position[i] - from[i];
    EXPECT_LT((way - way.dot(downhill) * downhill).norm(), 1e-3 * travel);
  }
}

TEST(GammatonTracer, WithoutFrictionADropOnAnInclineGainsWhatItFallsBy) {
  Scene scene = scene_with(incline(1000, 60, 40));
  scene.emitters[0].position_mm = {0, 10, 0};
  scene.emitters[0].gammatons = 1;
  scene.gravity_mm_s2 = {0, -kGravity, 0};
  scene.behavior = {
      .bounce = 0.0, .floating = 1.0, .absorb = 0.0, .deceleration_bounce = 0.0, .deceleration_float = 0.0};
  scene.tracing.lobe_exponent_float = 1e6;
  scene.tracing.tangential_slowdown = false;
  TracedScene run(scene);
  while (run.sum.contacts < 1) run.step();
  run.step();
  const double y0 = run.gammatons.position[0].y(), v0 = run.gammatons.velocity[0].squaredNorm();
  for (int k = 0; k < 150; ++k) run.step();
  const double gained = run.gammatons.velocity[0].squaredNorm() - v0;
  EXPECT_NEAR(gained, 2.0 * kGravity * (y0 - run.gammatons.position[0].y()), 1e-3 * gained);
}

TEST(GammatonTracer, FrictionBringsADropToItsTerminalSpeed) {
  // v'^2 = f^2 (v^2 + 2 a s) has the mean f^2 2 a s / (1 - f^2) for strides of mean s.
  constexpr double kKept = 0.8;
  Scene scene = scene_with(incline(2000, 90, 40));
  scene.emitters[0].position_mm = {100, 800, 0};
  scene.emitters[0].direction = {-1, 0, 0};
  scene.emitters[0].gammatons = 100;
  scene.gravity_mm_s2 = {0, -kGravity, 0};
  scene.behavior = {
      .bounce = 0.0, .floating = 1.0, .absorb = 0.0, .deceleration_bounce = 0.0, .deceleration_float = 1.0 - kKept};
  scene.tracing.lobe_exponent_float = 1e6;
  TracedScene run(scene);
  for (int k = 0; k < 200; ++k) run.step();
  const double stride = 0.75 * scene.tracing.epsilon_mm / scene.tracing.pull;  // [1/2, 1) of it
  const double mean_square = kKept * kKept * 2.0 * kGravity * stride / (1.0 - kKept * kKept);
  double sum = 0.0;
  for (const Vec3& v : run.gammatons.velocity) {
    sum += v.squaredNorm();
    EXPECT_NEAR(v.y(), -v.norm(), 0.01 * v.norm());
  }
  // Strides' relative deviation is 0.192; of the geometric sum (1 - f^2) / sqrt(1 - f^4) of that is left, a tenth for
  // 100 drops.
  constexpr double kFourSigma = 4.0 * 0.192 * 0.36 / 0.768 / 10.0;
  EXPECT_NEAR(sum / 100.0, mean_square, kFourSigma * mean_square);
}

/// A cylinder that lies along z, closed by two fans.
Mesh lying_cylinder(double radius, double length, int sides) {
  Mesh mesh;
  for (const double z : {-0.5 * length, 0.5 * length}) {
    for (int i = 0; i < sides; ++i) {
      const double a = 2.0 * std::numbers::pi * i / sides;
      mesh.positions.push_back({radius * std::cos(a), radius * std::sin(a), z});
    }
  }
  mesh.positions.push_back({0, 0, -0.5 * length});
  mesh.positions.push_back({0, 0, 0.5 * length});
  for (int i = 0; i < sides; ++i) {
    const int j = (i + 1) % sides;
    mesh.triangles.push_back({i, j, sides + j});
    mesh.triangles.push_back({i, sides + j, sides + i});
    mesh.triangles.push_back({j, i, 2 * sides});
    mesh.triangles.push_back({sides + i, sides + j, 2 * sides + 1});
  }
  mesh.surfaces = {{"cylinder", ""}};
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  return with_any_uvs(mesh);
}

TEST(GammatonTracer, DropsRunRoundALyingCylinderAndDripOffItsUnderside) {
  constexpr double kRadius = 40.0;
  Scene scene = scene_with(lying_cylinder(kRadius, 200, 128), 256);
  scene.emitters[0] = {.name = "rain",
                       .shape = EmitterShape::Rectangle,
                       .position_mm = {0, 60, 0},
                       .direction = {0, -1, 0},
                       .size_mm = {70, 100},
                       .gammatons = 2000};
  scene.gravity_mm_s2 = {0, -kGravity, 0};
  scene.behavior = {
      .bounce = 0.0, .floating = 1.0, .absorb = 0.0, .deceleration_bounce = 0.0, .deceleration_float = 0.3};
  scene.tracing.rest_speed_mm_s = 0.0;
  TracedScene run(scene);
  run.trace();
  run.scene.emitters[0].is_on = false;
  run.respond();
  int num_dripped = 0;
  std::vector<GammatonState> before = run.gammatons.state;
  std::vector<double> angles;
  for (int k = 0; k < 400; ++k) {
    run.step();
    for (std::size_t i = 0; i < before.size(); ++i) {
      const Vec3& p = run.gammatons.position[i];
      if (before[i] == GammatonState::Floating && run.gammatons.state[i] == GammatonState::Flying) {
        ++num_dripped;
        angles.push_back(std::abs(std::atan2(p.x(), -p.y())) * 180.0 / std::numbers::pi);  // 0 = right below
      }
      if (run.gammatons.state[i] != GammatonState::Waiting) {
        EXPECT_GT(p.head<2>().norm(), kRadius * std::cos(std::numbers::pi / 128) - 1e-3) << "inside the cylinder";
      }
    }
    before = run.gammatons.state;
  }
  EXPECT_EQ(run.sum.left, 2000);
  std::sort(angles.begin(), angles.end());
  ASSERT_GT(num_dripped, 1900);
  EXPECT_LT(angles[angles.size() / 2], 6.0);  // two facets of 2.8 degrees
  EXPECT_LT(angles[angles.size() * 95 / 100], 30.0);
}

TEST(GammatonTracer, DropsRunDownAWallRoundItsLowerEdgeAndDripThere) {
  Scene scene = scene_with(with_any_uvs(make_cube(100.0)), 256);
  scene.emitters[0] = {.name = "hose",
                       .shape = EmitterShape::Rectangle,
                       .position_mm = {130, 90, 50},
                       .direction = {-1, 0, 0},
                       .size_mm = {60, 10},
                       .gammatons = 500};
  scene.gravity_mm_s2 = {0, -kGravity, 0};
  scene.behavior = {
      .bounce = 0.0, .floating = 1.0, .absorb = 0.0, .deceleration_bounce = 0.0, .deceleration_float = 0.3};
  TracedScene run(scene);
  run.trace();
  run.scene.emitters[0].is_on = false;
  run.respond();
  int num_dripped = 0;
  double farthest = 0.0;
  for (int k = 0; k < 300; ++k) {
    const std::vector<GammatonState> before = run.gammatons.state;
    run.step();
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (before[i] != GammatonState::Floating || run.gammatons.state[i] != GammatonState::Flying) continue;
      ++num_dripped;
      farthest = std::max(farthest, 100.0 - run.gammatons.position[i].x());
      EXPECT_NEAR(run.gammatons.position[i].y(), 0.0,
                  scene.tracing.epsilon_mm + scene.tracing.pull * scene.tracing.reach_mm);
    }
  }
  EXPECT_EQ(num_dripped, 500);
  EXPECT_EQ(run.sum.left, 500);
  EXPECT_LT(farthest, scene.tracing.reach_mm) << "dripped from the middle of the underside";
}

TEST(GammatonTracer, DropsOnAWallRunAlongGravity) {
  // A cube whose normals are smoothed round its edges, as some files have it: off by 55 degrees at its corners.
  constexpr double kTenth = 0.1 * std::numbers::pi / 180.0;
  for (const double exponent : {100.0, 1e6}) {
    Scene scene = scene_with(with_any_uvs(make_cube(400.0)), 256);
    scene.objects[0].mesh.normals = vertex_normals(scene.objects[0].mesh);
    scene.objects[0].mesh.normal_triangles = scene.objects[0].mesh.triangles;
    scene.emitters[0] = {.name = "hose",
                         .shape = EmitterShape::Rectangle,
                         .position_mm = {500, 330, 260},
                         .direction = {-1, 0, 0},
                         .size_mm = {100, 60},
                         .gammatons = 20000};
    scene.gravity_mm_s2 = {0, -kGravity, 0};
    scene.behavior = {
        .bounce = 0.0, .floating = 1.0, .absorb = 0.0, .deceleration_bounce = 0.0, .deceleration_float = 0.3};
    scene.tracing.lobe_exponent_float = exponent;
    TracedScene run(scene);
    while (run.sum.contacts < 20000) run.step();
    run.scene.emitters[0].is_on = false;
    for (int k = 0; k < 20; ++k) run.step();  // the way in is forgotten
    const std::vector<Vec3> from = run.gammatons.position;
    for (int k = 0; k < 150; ++k) run.step();
    double sum = 0.0, square = 0.0, fallen = 0.0;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const Vec3 way = run.gammatons.position[i] - from[i];
      if (exponent == 1e6) {
        EXPECT_LT(std::abs(way.z()), kTenth * -way.y());
      }
      sum += way.z();
      square += way.z() * way.z();
      fallen -= way.y();
    }
    const double error = std::sqrt(square) / fallen;  // of the mean
    EXPECT_LT(error, 0.2 * kTenth) << "enough drops to tell";
    EXPECT_LT(std::abs(sum / fallen), kTenth) << "lobe exponent " << exponent;
  }
}

TEST(GammatonTracer, EqualBitsForAnyNumberOfThreads) {
  std::vector<std::string> hashes;
  for (const int threads : {1, 2, 3, 8}) {
    Scene scene = scene_with(with_any_uvs(make_icosphere(50.0, 3)), 128);
    scene.emitters[0] = {.name = "rain", .shape = EmitterShape::Sky, .spread_deg = 30, .gammatons = 9000};
    scene.emitters.push_back({.name = "ball",
                              .shape = EmitterShape::Sphere,
                              .position_mm = {0, 80, 0},
                              .size_mm = {20, 20},
                              .spread_deg = 60,
                              .gammatons = 3000});
    scene.gravity_mm_s2 = {0, -kGravity, 0};
    scene.behavior = {};
    TracedScene run(scene);
    ContentHash hash;
    for (int k = 0; k < 40; ++k) {
      run.step(threads);
      for (const Contact& c : run.traced.contacts)
        hash.add(std::int64_t{c.texel}).add(std::int64_t{c.gammaton}).add(std::int64_t{c.is_landing});
      for (const std::uint32_t b : run.traced.born) hash.add(std::as_bytes(std::span(&b, 1)));
    }
    run.gammatons.for_each_array([&](std::string_view, auto& array) { hash.add(std::as_bytes(std::span(array))); });
    hashes.push_back(hash.hex());
    EXPECT_GT(run.sum.contacts, 10000);
    EXPECT_GT(run.sum.absorbed, 0);
    EXPECT_GT(run.sum.left, 0);
  }
  for (const std::string& h : hashes) EXPECT_EQ(h, hashes[0]);
}

TEST(GammatonTracer, DeathsAndBirthsAreListedOnce) {
  Scene scene = scene_with(with_any_uvs(make_icosphere(50.0, 3)), 128);
  scene.emitters[0] = {.name = "rain", .shape = EmitterShape::Sky, .gammatons = 3000};
  scene.gravity_mm_s2 = {0, -kGravity, 0};
  scene.behavior = {};
  TracedScene run(scene);
  std::vector<int> alive(3000, 0);
  for (int k = 0; k < 50; ++k) {
    run.step();
    for (const std::uint32_t b : run.traced.born) EXPECT_EQ(++alive[b], 1);
    for (const TraceResult* r : {&run.traced, &run.responded}) {
      for (const Death& d : r->died) EXPECT_EQ(--alive[d.gammaton], 0);
    }
    for (std::size_t i = 0; i < alive.size(); ++i)
      ASSERT_EQ(alive[i] != 0, run.gammatons.state[i] != GammatonState::Waiting);
  }
}

TEST(GammatonTracer, AMovedObjectIsHitWhereItIs) {
  Scene scene = scene_with(incline(100, 0));
  scene.emitters[0].position_mm = {0, 50, 0};
  scene.emitters[0].gammatons = 10;
  TracedScene run(scene);
  run.step();
  EXPECT_NEAR(run.gammatons.position[0].y(), 0.0, 1e-6);
  run.scene.objects[0].translate_mm = {3, -20, 0};
  place_objects(run.mesh, run.scene);
  run.tracer.set_mesh(run.mesh);
  const SceneMesh fresh_mesh = make_scene_mesh(run.scene);
  const RayTracer fresh(fresh_mesh.mesh);
  run.step();
  EXPECT_NEAR(run.gammatons.position[0].y(), -20.0, 1e-5);
  for (int k = 0; k < 100; ++k) {
    const Vec3 origin(k - 50, 40, 0.3 * k);
    const TriangleHit a = run.tracer.rays().first_hit(origin, {0.1, -1, 0.2}, 0.0, 1e30),
                      b = fresh.first_hit(origin, {0.1, -1, 0.2}, 0.0, 1e30);
    EXPECT_EQ(a.triangle, b.triangle);
    EXPECT_EQ(a.distance, b.distance);
  }
}

}  // namespace
}  // namespace patinate::simulation
