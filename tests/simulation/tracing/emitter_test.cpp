#include "simulation/tracing/emitter.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "simulation/tracing/scene_checks.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/simulation/tracing/chi_square.h"
#include "tests/simulation/tracing/tracing_scene.h"
#include "tests/support/errors.h"
#include "tests/support/test_data.h"

namespace patinate::simulation {
namespace {

using testing_support::chi_square_limit;
using testing_support::chi_square_of_equal;
using testing_support::error_of;
using testing_support::has;
using testing_support::make_icosphere;
using testing_support::make_patch;
using testing_support::scene_with;
using testing_support::TracedScene;
using testing_support::with_any_uvs;

const std::uint32_t kBirths = testing_support::sample_count(100000u);

Mesh floor_of(double side) {
  return make_patch(2, 2, [&](double u, double v) { return Vec3((u - 0.5) * side, 0.0, (0.5 - v) * side); });
}

/// An emitter of a scene with a ball.
PlacedEmitter placed(const Emitter& emitter, Mesh mesh = make_icosphere(50.0, 3), const Vec3& gravity = Vec3::Zero()) {
  const SceneMesh scene_mesh = make_scene_mesh(scene_with(with_any_uvs(std::move(mesh))));
  return place_emitter(emitter, scene_mesh, RayTracer(scene_mesh.mesh), gravity);
}

TEST(Emitter, DiskIsUniformInArea) {
  const Vec3 direction = Vec3(1, -2, 0.5).normalized();
  const PlacedEmitter disk = placed(
      {.name = "e", .shape = EmitterShape::Disk, .position_mm = {1, 2, 3}, .direction = direction, .size_mm = {30, 0}});
  std::array<double, 10> rings{};
  std::array<double, 8> sectors{};
  for (std::uint32_t k = 0; k < kBirths; ++k) {
    const Vec3 p = make_birth(disk, 1, 7, k).position - Vec3(1, 2, 3);
    EXPECT_NEAR(p.dot(direction), 0.0, 1e-9);
    const double share = p.squaredNorm() / (15.0 * 15.0);
    ASSERT_LE(share, 1.0 + 1e-9);
    rings[std::min<std::size_t>(9, static_cast<std::size_t>(10.0 * share))] += 1.0;
    sectors[std::min<std::size_t>(
        7,
        static_cast<std::size_t>(8.0 * (std::atan2(p.dot(disk.v), p.dot(disk.u)) / (2.0 * std::numbers::pi) + 0.5)))] +=
        1.0;
  }
  EXPECT_LT(chi_square_of_equal(rings), chi_square_limit(9));
  EXPECT_LT(chi_square_of_equal(sectors), chi_square_limit(7));
}

TEST(Emitter, RectangleIsUniformAndItsFirstSideLiesAlongX) {
  const PlacedEmitter rectangle =
      placed({.name = "e", .shape = EmitterShape::Rectangle, .direction = {0, -1, 0}, .size_mm = {40, 10}});
  std::array<double, 32> cells{};
  for (std::uint32_t k = 0; k < kBirths; ++k) {
    const Birth birth = make_birth(rectangle, 1, 7, k);
    ASSERT_LE(std::abs(birth.position.x()), 20.0);
    ASSERT_LE(std::abs(birth.position.z()), 5.0);
    EXPECT_EQ(birth.velocity.y(), -1000.0);
    const auto x = static_cast<std::size_t>((birth.position.x() + 20.0) / 5.0),
               z = static_cast<std::size_t>((birth.position.z() + 5.0) / 2.5);
    cells[std::min<std::size_t>(7, x) * 4 + std::min<std::size_t>(3, z)] += 1.0;
  }
  EXPECT_LT(chi_square_of_equal(cells), chi_square_limit(31));
}

TEST(Emitter, SphereIsUniformAndOutward) {
  const PlacedEmitter sphere =
      placed({.name = "e", .shape = EmitterShape::Sphere, .position_mm = {5, 0, 0}, .size_mm = {20, 0}});
  std::array<double, 20> by_height{};  // equal areas [Archimedes]
  for (std::uint32_t k = 0; k < kBirths; ++k) {
    const Birth birth = make_birth(sphere, 1, 7, k);
    const Vec3 r = birth.position - Vec3(5, 0, 0);
    EXPECT_NEAR(r.norm(), 10.0, 1e-9);
    EXPECT_NEAR(birth.velocity.dot(r), 1000.0 * 10.0, 1e-5);
    by_height[std::min<std::size_t>(19, static_cast<std::size_t>(r.y() + 10.0))] += 1.0;
  }
  EXPECT_LT(chi_square_of_equal(by_height), chi_square_limit(19));
}

TEST(Emitter, SkyRainsOnAllPlacesAlike) {
  // Slanting rain with spread, under gravity that bends it, on a floor with a post that makes the scene high.
  Mesh mesh = floor_of(200);
  const int first = static_cast<int>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {{90, 0, 90}, {90.001, 150, 90}, {90, 0, 90.001}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangle_surface.push_back(0);
  Scene scene = scene_with(with_any_uvs(mesh));
  scene.emitters[0] = {.name = "rain",
                       .shape = EmitterShape::Sky,
                       .direction = Vec3(0.5, -1, 0.2).normalized(),
                       .spread_deg = 25,
                       .speed_mm_s = 800,
                       .gammatons = 200000};
  scene.gravity_mm_s2 = {0, -9810, 0};
  TracedScene run(scene);
  for (int k = 0; k < 20; ++k) {
    run.step();
    run.scene.emitters[0].is_on = false;
  }
  std::array<double, 64> cells{};
  double total = 0.0;
  for (const Vec3& p : run.gammatons.position) {
    if (std::abs(p.y()) > 0.1 || std::abs(p.x()) > 100 || std::abs(p.z()) > 100) continue;
    cells[std::min<std::size_t>(7, static_cast<std::size_t>((p.x() + 100) / 25)) * 8 +
          std::min<std::size_t>(7, static_cast<std::size_t>((p.z() + 100) / 25))] += 1.0;
    total += 1.0;
  }
  EXPECT_GT(total, 10000);
  EXPECT_LT(chi_square_of_equal(cells), chi_square_limit(63));
}

TEST(Emitter, BrushSitsOnTheSurfaceAndLooksDownItsNormal) {
  for (const bool is_inside_out : {false, true}) {
    Mesh ball = make_icosphere(50.0, 4);
    if (is_inside_out) {
      for (Triangle& t : ball.triangles) std::swap(t[1], t[2]);
    }
    const Vec3 at = Vec3(1, 2, -1).normalized();
    const PlacedEmitter brush = placed({.name = "brush",
                                        .shape = EmitterShape::Surface,
                                        .position_mm = 70.0 * at,
                                        .size_mm = {4, 0},
                                        .distance_mm = 10.0},
                                       ball);
    constexpr double kFacet = 0.1;  // sagitta of the facets, and their slope times 10 mm
    EXPECT_NEAR((brush.center - 60.0 * at).norm(), 0.0, 10.0 * kFacet);
    EXPECT_NEAR(brush.center.norm(), 60.0, kFacet);
    EXPECT_GT(-brush.direction.dot(at), 0.995);
    for (std::uint32_t k = 0; k < 100; ++k) {
      const Birth birth = make_birth(brush, 1, 0, k);
      EXPECT_LT((birth.position - brush.center).norm(), 2.0 + 1e-9);
      EXPECT_LT(birth.velocity.dot(at), 0.0);
    }
  }
}

TEST(Emitter, BrushStaysBelowACeiling) {
  Mesh plates = floor_of(100);
  const int first = static_cast<int>(plates.positions.size());
  const std::size_t n = plates.triangles.size();
  for (int i = 0; i < first; ++i) plates.positions.push_back(plates.positions[i] + Vec3(0, 4, 0));
  for (std::size_t i = 0; i < n; ++i) {
    const Triangle t = plates.triangles[i];
    plates.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    plates.triangle_surface.push_back(0);
  }
  const PlacedEmitter brush = placed({.name = "brush",
                                      .shape = EmitterShape::Surface,
                                      .position_mm = {3, 0, 5},
                                      .size_mm = {1, 0},
                                      .distance_mm = 10.0},
                                     plates);
  EXPECT_NEAR(brush.center.y(), 2.0, 1e-6);
}

TEST(Emitter, BirthsDependOnSeedGammatonAndNumberAlone) {
  const PlacedEmitter point = placed({.name = "e", .shape = EmitterShape::Point, .spread_deg = 180});
  const Birth a = make_birth(point, 1, 2, 3);
  EXPECT_EQ(a.velocity, make_birth(point, 1, 2, 3).velocity);
  EXPECT_NE(a.velocity, make_birth(point, 2, 2, 3).velocity);
  EXPECT_NE(a.velocity, make_birth(point, 1, 3, 3).velocity);
  EXPECT_NE(a.velocity, make_birth(point, 1, 2, 4).velocity);
}

TEST(CheckEmitters, NamesEmitterAndObject) {
  Scene scene = scene_with(with_any_uvs(make_icosphere(50.0, 3)));
  const auto error = [&] {
    const SceneMesh mesh = make_scene_mesh(scene);
    return error_of([&] { check_emitters(scene, mesh, RayTracer(mesh.mesh)); });
  };
  scene.emitters[0].position_mm = {10, 20, -30};
  EXPECT_TRUE(has(error(), "emitter 'rain' lies inside object 'object'")) << error();
  scene.emitters[0].is_on = false;
  EXPECT_EQ(error(), "");
  scene.emitters[0].is_on = true;
  scene.emitters[0].position_mm = {0, 51, 0};
  EXPECT_EQ(error(), "");
  scene.emitters[0].shape = EmitterShape::Rectangle;
  scene.emitters[0].position_mm = {0, 48, 0};
  scene.emitters[0].size_mm = {100, 100};
  EXPECT_TRUE(has(error(), "in part inside object")) << error();
  scene.emitters[0].shape = EmitterShape::Sky;
  EXPECT_EQ(error(), "");
  scene.objects[0].mesh = with_any_uvs(floor_of(100));
  scene.emitters[0].shape = EmitterShape::Point;
  EXPECT_EQ(error(), "") << "an open mesh has no inside";
}

TEST(DescribeMeshes, SaysWhatIsOpenOrInsideOut) {
  Scene scene = scene_with(with_any_uvs(make_icosphere(50.0, 2)));
  EXPECT_TRUE(describe_meshes(make_scene_mesh(scene)).empty());
  for (std::size_t t = 0; t < scene.objects[0].mesh.triangles.size(); ++t) {
    std::swap(scene.objects[0].mesh.triangles[t][1], scene.objects[0].mesh.triangles[t][2]);
  }
  SceneObject sheet;
  sheet.name = "sheet";
  sheet.mesh = with_any_uvs(floor_of(10));
  scene.objects.push_back(sheet);
  const std::vector<std::string> lines = describe_meshes(make_scene_mesh(scene));
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_TRUE(has(lines[0], "object 'object' is inside out"));
  EXPECT_TRUE(has(lines[1], "object 'sheet' is open (1 holes"));
}

TEST(GammatonTracer, AnInsideOutBallIsRainedOnLikeAnother) {
  std::array<std::int64_t, 2> contacts{};
  for (std::size_t k = 0; k < 2; ++k) {
    Mesh ball = make_icosphere(50.0, 3);
    if (k == 1) {
      for (Triangle& t : ball.triangles) std::swap(t[1], t[2]);
    }
    Scene scene = scene_with(with_any_uvs(ball));
    scene.emitters[0] = {.name = "rain", .shape = EmitterShape::Sky, .gammatons = 5000};
    scene.gravity_mm_s2 = {0, -9810, 0};
    scene.behavior = {};
    TracedScene run(scene);
    for (int i = 0; i < 40; ++i) run.step();
    for (std::size_t i = 0; i < run.gammatons.size(); ++i) {
      if (run.gammatons.state[i] == GammatonState::Floating) {
        EXPECT_GT(run.gammatons.position[i].norm(), 49.0);
      }
    }
    contacts[k] = run.sum.contacts;
  }
  EXPECT_NEAR(static_cast<double>(contacts[0]), static_cast<double>(contacts[1]),
              4.0 * std::sqrt(static_cast<double>(contacts[0])));
}

}  // namespace
}  // namespace patinate::simulation
