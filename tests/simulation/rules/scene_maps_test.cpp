#include "simulation/rules/scene_maps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets_synthetic/bars.h"
#include "patinate/simulation/engine.h"
#include "simulation/rules/boards.h"
#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;

/// Two equal plates, side by side.
Scene two_plates() {
  Scene scene = testing_support::plate_scene(128);
  SceneObject other = scene.objects[0];
  other.name = "other";
  other.translate_mm = Vec3(150, 0, 0);
  scene.objects.push_back(other);
  return scene;
}

struct Made {
  explicit Made(const Scene& scene, std::vector<std::string> names)
      : scene_mesh(make_scene_mesh(scene)),
        surface(scene_mesh, scene.resolution),
        maps(make_parameters(names, scene, scene_mesh, surface, {})) {}

  [[nodiscard]] double value(TexelIndex t, std::size_t map = 0) const {
    std::array<float, TileGrid::kTileTexels> tile;
    load_parameter(maps[map], TileGrid::tile_of(t), tile.data());
    return static_cast<double>(tile[t % TileGrid::kTileTexels]);
  }
  [[nodiscard]] int object(TexelIndex t) const {
    return surface.is_covered(t) ? surface.object(surface.triangle(t)) : -1;
  }

  SceneMesh scene_mesh;
  SurfaceAtlas surface;
  std::vector<SurfaceParameter> maps;
};

SceneMap noise_map(double wavelength_mm) {
  SceneMap map{
      .name = "grain", .kind = "noise", .options = {}, .noise = {}, .wood_grain = {}, .images = {}, .is_inside = {}};
  map.noise.wavelength_mm = wavelength_mm;
  return map;
}

TEST(SceneMaps, NoiseBelongsToTheObjectWhereverItStands) {
  Scene here = testing_support::plate_scene(128);
  here.maps = {noise_map(20)};
  Scene there = here;
  there.objects[0].translate_mm = Vec3(1000, -37, 5);
  there.objects[0].rotate_deg = Vec3(10, 20, 30);
  const Made a(here, {"grain"}), b(there, {"grain"});
  for (TexelIndex t = 0; t < a.surface.grid().num_texels(); ++t) ASSERT_EQ(a.value(t), b.value(t));
}

TEST(SceneMaps, NoiseOfEqualObjectsDiffers) {
  Scene scene = two_plates();
  scene.maps = {noise_map(20)};
  const Made made(scene, {"grain"});
  const TileGrid& grid = made.surface.grid();
  const int side = static_cast<int>(std::lround(made.scene_mesh.uv_squares[0][2] * scene.resolution));
  double product = 0.0, square = 0.0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      std::array<double, 2> v{};
      for (std::size_t i = 0; i < 2; ++i) {
        const auto& [u0, v0, s0] = made.scene_mesh.uv_squares[i];
        const TexelIndex t = grid.index(static_cast<int>(std::lround(u0 * 128)) + x,
                                        static_cast<int>(std::lround((1 - v0 - s0) * 128)) + y);
        v[i] = made.value(t) - 0.5;
      }
      product += v[0] * v[1];
      square += v[0] * v[0];
    }
  }
  EXPECT_LT(std::abs(product), 0.5 * square);  // about 25 patches: 1 / sqrt(25), and 2.5 of that
}

/// Bars side by side, joined to nothing: two along x, one upright, in one mesh.
Scene bars() {
  Scene scene = testing_support::plate_scene(256);
  std::vector<datasets::Face> faces;
  const auto bar = [&](double x0, double x1, double y0, double y1) {
    datasets::add_bar(faces, x0, x1, {Vec2(y0, 10), Vec2(y0, 0), Vec2(y1, 0), Vec2(y1, 10)}, 20);
  };
  bar(0, 200, 0, 40);
  bar(0, 200, 45, 85);
  bar(210, 250, 0, 200);
  scene.objects[0].mesh = datasets::mesh_of_faces(faces, 200, "bars", "wood");
  scene.maps = {{.name = "rings",
                 .kind = "wood_grain",
                 .options = {},
                 .noise = {},
                 .wood_grain = {},
                 .images = {},
                 .is_inside = {}}};
  scene.maps[0].wood_grain.ring_mm = 8;
  return scene;
}

TEST(SceneMaps, EveryPieceIsABoardWithItsGrainAlongItsLongestSide) {
  Scene scene = bars();
  scene.objects[0].rotate_deg = Vec3::Zero();
  const SceneMesh scene_mesh = make_scene_mesh(scene);
  const Boards boards = find_boards(scene_mesh, {5});
  ASSERT_EQ(boards.boards.size(), 3u);
  EXPECT_EQ(boards.boards[0].along, Vec3::UnitX());
  EXPECT_EQ(boards.boards[1].along, Vec3::UnitX());
  EXPECT_EQ(boards.boards[2].along, Vec3::UnitY());
  EXPECT_DOUBLE_EQ(boards.boards[2].half_width_mm, 20.0);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(boards.boards[i].number, 5 + static_cast<std::int64_t>(i));
}

TEST(SceneMaps, GrainOfWoodBelongsToTheObjectWhereverItStands) {
  Scene here = bars(), there = bars();
  there.objects[0].translate_mm = Vec3(1000, -37, 5);
  there.objects[0].rotate_deg = Vec3(10, 20, 30);
  const Made a(here, {"rings"}), b(there, {"rings"});
  double least = 1.0, most = 0.0;
  for (TexelIndex t = 0; t < a.surface.grid().num_texels(); ++t) {
    ASSERT_EQ(a.value(t), b.value(t));
    if (!a.surface.is_covered(t)) continue;
    least = std::min(least, a.value(t));
    most = std::max(most, a.value(t));
  }
  EXPECT_LT(least, 0.2);
  EXPECT_GT(most, 0.6);
}

TEST(SceneMaps, AnImageLiesOverEachObjectsOwnUvs) {
  Scene scene = two_plates();
  SceneMap map{
      .name = "wet", .kind = "image", .options = {}, .noise = {}, .wood_grain = {}, .images = {}, .is_inside = {}};
  ImageF left(64, 64, 1);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 32; ++x) left.at(x, y) = 1.0F;
  }
  map.images = {ImageF(), left};
  scene.maps = {map};
  const Made made(scene, {"wet"});
  const auto& [u0, v0, side] = made.scene_mesh.uv_squares[1];
  for (TexelIndex t = 0; t < made.surface.grid().num_texels(); ++t) {
    if (made.object(t) == 0) {
      ASSERT_EQ(made.value(t), 0.0);
    }
    if (made.object(t) != 1) continue;
    const double u = ((made.surface.grid().x(t) + 0.5) / 128 - u0) / side;
    if (u < 0.48) {
      ASSERT_EQ(made.value(t), 1.0) << u;
    }
    if (u > 0.52) {
      ASSERT_EQ(made.value(t), 0.0) << u;
    }
  }
}

TEST(SceneMaps, AKindThatNeedsNoInputIsThereByItsName) {
  const Scene scene = testing_support::plate_scene(64);
  const Made made(scene, {"facing", "sun", "noise", "slope"});
  const TexelIndex t = made.surface.grid().index(32, 32);
  EXPECT_NEAR(made.value(t, 0), std::cos(30 * 3.14159265358979 / 180), 1e-4);  // tilted by 30 degrees
  EXPECT_NEAR(made.value(t, 0), 1 - 2 * made.value(t, 3), 0.01);               // slopes have 8 bits
  EXPECT_GT(made.value(t, 1), 0.0);
}

TEST(SceneMaps, OfTheScenesOwnComeBeforeThoseThatAreBuiltIn) {
  Scene scene = testing_support::plate_scene(64);
  SceneMap map{
      .name = "facing", .kind = "facing", .options = {}, .noise = {}, .wood_grain = {}, .images = {}, .is_inside = {}};
  map.options.facing.direction = {0, -1, 0};
  scene.maps = {map};
  const Made made(scene, {"facing"});
  EXPECT_EQ(made.value(made.surface.grid().index(32, 32)), 0.0);
}

TEST(SceneMaps, ARuleLimitedToAnObjectActsThereAlone) {
  Scene scene = two_plates();
  scene.emitters[0].is_on = false;
  SceneMap map{
      .name = "left", .kind = "objects", .options = {}, .noise = {}, .wood_grain = {}, .images = {}, .is_inside = {}};
  map.is_inside = {true, false};
  scene.maps = {map, noise_map(30)};
  Rule rule{.name = "rust", .driver = "metal", .rate = 0.5};
  rule.products[2] = 1.0;
  rule.where = "left * smoothstep(0.4, 0.6, grain)";
  scene.rules = {rule};
  Simulation simulation(scene);
  for (int i = 0; i < 80; ++i) simulation.step();
  const Made made(scene, {"left", "grain"});
  std::int64_t num_rusty = 0;
  for (TexelIndex t = 0; t < made.surface.grid().num_texels(); ++t) {
    if (made.object(t) < 0) continue;
    const std::uint16_t rust = simulation.atlas().amount(2, t);
    if (made.object(t) == 1 || made.value(t, 1) < 0.399) {
      ASSERT_EQ(rust, 0);
    }
    if (made.object(t) == 0 && made.value(t, 1) > 0.601) {
      ++num_rusty;
      ASSERT_GT(rust, 0.5 * 3.5 * kAmountOne);
    }
  }
  EXPECT_GT(num_rusty, 100);
}

TEST(SceneMaps, InitialAmountsAreWhatTheExpressionSaysAndTheBooksBalance) {
  Scene scene = two_plates();
  scene.maps = {noise_map(30)};
  scene.objects[1].initial[0] = "2 * grain";
  scene.objects[1].initial[1] = "0.25";  // less than the preset's 1
  Simulation simulation(scene);
  const Made made(scene, {"grain"});
  for (TexelIndex t = 0; t < made.surface.grid().num_texels(); ++t) {
    if (made.object(t) < 0) continue;
    const bool is_other = made.object(t) == 1;
    ASSERT_NEAR(simulation.atlas().amount(0, t), is_other ? 2 * made.value(t) * kAmountOne : 0.0, 1.0);
    ASSERT_EQ(simulation.atlas().amount(1, t), is_other ? kAmountOne / 4 : kAmountOne);
    ASSERT_EQ(simulation.atlas().original(1, t), kAmountOne) << "what the plate is made of stays";
  }
  EXPECT_EQ(simulation.audit(), "");
  EXPECT_TRUE(simulation.ledger().balances());
  for (int i = 0; i < 20; ++i) simulation.step();
  EXPECT_EQ(simulation.audit(), "");
  Simulation resumed(scene);
  resumed.restore(simulation.snapshot());
  EXPECT_EQ(resumed.audit(), "");
  EXPECT_EQ(resumed.atlas().hash(), simulation.atlas().hash());
}

TEST(SceneMaps, WhatCannotBeIsNamed) {
  const auto says = [](auto&& change) {
    Scene scene = testing_support::plate_scene(64);
    scene.maps = {noise_map(20)};
    change(scene);
    return error_of([&] { Simulation{scene}; });
  };
  EXPECT_EQ(says([](Scene&) {}), "");
  EXPECT_TRUE(has(says([](Scene& s) { s.maps[0].name = "water"; }), "a map is called 'water' as a material is"));
  EXPECT_TRUE(has(says([](Scene& s) { s.maps[0].name = "two words"; }), "use letters, digits and _"));
  EXPECT_TRUE(has(says([](Scene& s) { s.maps.push_back(s.maps[0]); }), "two maps are called 'grain'"));
  EXPECT_TRUE(has(says([](Scene& s) { s.objects[0].initial[0] = "water"; }),
                  "initial water of object 'plate' `water`: position 1: unknown map `water`"));
  EXPECT_TRUE(has(says([](Scene& s) {
                    s.rules = {testing_support::rust_rule(1)};
                    s.rules[0].where = "grian";
                  }),
                  "rule 'rust': where `grian`: position 1: unknown material or parameter `grian`; there are "));
}

}  // namespace
}  // namespace patinate::simulation
