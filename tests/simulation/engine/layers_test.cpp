#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "patinate/core/error.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/layer_atlas.h"
#include "simulation/rules/rules.h"
#include "tests/simulation/engine/run_iterations.h"
#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::run_iterations;

constexpr int kPrimer = 1, kPaint = 2;
constexpr std::size_t kWater = 0, kMetal = 1, kRust = 2;

/// The plate of steel under primer and paint, in dense rain that dries.
Scene coated_plate(int resolution = 96) {
  Scene scene = testing_support::plate_scene(resolution);
  scene.emitters[0].gammatons = 300;
  scene.time_per_iteration = 0.0625;  // Powers of two: wear is whole quanta.
  SceneObject& plate = scene.objects[0];
  plate.layers = {{.name = "steel", .look = plate.preset},
                  {.name = "primer", .thickness_um = "40"},
                  {.name = "paint", .thickness_um = "60"}};
  plate.preset.amounts = {};
  plate.layers[kPrimer].look.color.color = Vec3(0.5, 0.5, 0.4);
  plate.layers[kPaint].look.color.color = Vec3(0.05, 0.3, 0.1);
  Rule drying{.name = "drying", .driver = "water", .rate = 0.5};
  drying.reactants[kWater] = 1.0;
  scene.rules.push_back(drying);
  return scene;
}

Rule wear(const std::string& driver, double um) {
  Rule rule{.name = "wear", .driver = driver, .rate = 1.0};
  rule.layer_reactants.thickness_um = um;
  return rule;
}

/// Everything that happens to layers, where it rains.
Scene weathered_plate() {
  Scene scene = coated_plate();
  scene.maps.push_back({.name = "spots",
                        .kind = "noise",
                        .options = {},
                        .noise = {.wavelength_mm = 15},
                        .wood_grain = {},
                        .images = {},
                        .is_inside = {}});
  scene.objects[0].layers[kPaint].adhesion = "smoothstep(0.3, 0.6, spots)";
  scene.rules.push_back(wear("min(1, 4*water) + 0.1", 9.0));
  Rule corrosion{.name = "corrosion", .driver = "min(1, 8*water) * below.metal * edge", .rate = 2.0, .layer = "primer"};
  corrosion.layer_products.at_interface[kRust] = 1.0;
  Rule loosening{.name = "loosening", .driver = "interface.rust + 0.2*water*edge", .rate = 1.0, .layer = "primer"};
  loosening.layer_reactants.adhesion = 1.0;
  Rule rust = testing_support::rust_rule(0.5);
  scene.rules.insert(scene.rules.end(), {corrosion, loosening, rust});
  return scene;
}

TEST(Layers, UnderConstantWearAreThroughAtThicknessOverRate) {
  constexpr double kRate = 8.0;  // um a unit of time: 60 um in 120 iterations
  Scene scene = coated_plate();
  scene.rules = {wear("1", kRate)};
  Simulation simulation(scene);
  const SurfaceAtlas& surface = simulation.atlas().surface();
  constexpr int kQuantaAnIteration = 8;  // kRate * 0.0625 * 16
  constexpr int kThickness = 60 * LayerAtlas::kQuantaPerUm;
  for (int i = 0; i < 130; ++i) {
    simulation.step();
    if (i % 10 != 9) continue;
    for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
      if (!surface.is_covered(t)) continue;
      const auto aged = static_cast<int>(RuleEngine::aged_iterations(TileGrid::tile_of(t), i));
      const int left = std::max(0, kThickness - kQuantaAnIteration * aged);
      ASSERT_EQ(simulation.layers()->thickness().amount(kPaint, t), left) << "iteration " << i;
      ASSERT_EQ(simulation.layers()->tops()[t], left > 0 ? kPaint : kPrimer);
    }
  }
  EXPECT_EQ(simulation.audit(), "");
}

TEST(Layers, WhatWasWornAndWhatFlakedAndWhatRemainsIsWhatTheyWere) {
  Simulation simulation(weathered_plate());
  const auto mass = [&](int layer) { return simulation.layers()->remaining()[LayerAtlas::account_index(0, layer)]; };
  const std::int64_t paint = mass(kPaint);
  for (int k = 0; k < 10; ++k) {
    run_iterations(simulation, 40);
    ASSERT_EQ(simulation.audit(), "");
    ASSERT_TRUE(simulation.ledger().balances());
  }
  const LayerAccount& account = simulation.layers()->account(0, kPaint);
  MassSum sum = account.worn;
  sum += account.flaked;
  sum += mass(kPaint);
  EXPECT_EQ(sum, account.start);
  EXPECT_EQ(account.start.value(), static_cast<double>(paint));
  EXPECT_GT(account.worn.value(), 0.05 * account.start.value());
  EXPECT_GT(account.flaked.value(), 0.0);
  EXPECT_GT(simulation.layers()->account(0, kPrimer).flaked.value(), 0.0);
}

TEST(Layers, HaveTheSameBitsForAnyNumberOfThreads) {
  Simulation one(weathered_plate());
  run_iterations(one, 300, 1);
  EXPECT_GT(one.layers()->interface_mass(kRust), 0);
  for (const int threads : {2, 3}) {
    Simulation other(weathered_plate());
    run_iterations(other, 300, threads);
    EXPECT_EQ(other.state_hash(), one.state_hash());
    EXPECT_TRUE(other.snapshot() == one.snapshot()) << threads << " threads";
  }
}

TEST(Layers, GoOnFromASnapshotAsIfNothingHadHappened) {
  Simulation whole(weathered_plate()), first(weathered_plate()), second(weathered_plate());
  run_iterations(whole, 260);
  run_iterations(first, 130);
  run_iterations(second, 5);
  second.restore(first.snapshot());
  run_iterations(second, 130);
  EXPECT_TRUE(second.snapshot() == whole.snapshot());
  EXPECT_TRUE(second.compose().codes().front() == whole.compose().codes().front());
  EXPECT_TRUE(
      std::equal(second.compose().codes().begin(), second.compose().codes().end(), whole.compose().codes().begin()));
}

TEST(Layers, ASnapshotOfASceneWithoutLayersIsRefused) {
  Scene plain = coated_plate();
  plain.objects[0].layers.clear();
  Simulation layered(coated_plate()), other(plain);
  EXPECT_TRUE(has(error_of([&] { layered.restore(other.snapshot()); }), "of another version or scene"));
  EXPECT_TRUE(has(error_of([&] { other.restore(layered.snapshot()); }), "of another version or scene"));
}

TEST(Layers, AndTheirMapsAreWhatTheyWereSetTo) {
  Simulation aged(weathered_plate()), shown(weathered_plate());
  run_iterations(aged, 200);
  for (std::size_t m = 0; m < aged.scene().materials.size(); ++m)
    shown.set_amounts(static_cast<int>(m), aged.amounts(static_cast<int>(m)));
  const std::vector<std::string> names = aged.layer_map_names();
  EXPECT_EQ(names, (std::vector<std::string>{"layer1.thickness_um", "layer1.adhesion", "layer1.interface.rust",
                                             "layer2.thickness_um", "layer2.adhesion", "layer2.interface.rust"}));
  for (std::size_t k = 0; k < names.size(); ++k) shown.set_layer_map(k, aged.layer_map(k));
  EXPECT_EQ(shown.state_hash(), aged.state_hash());
  EXPECT_TRUE(
      std::equal(aged.compose().codes().begin(), aged.compose().codes().end(), shown.compose().codes().begin()));
}

TEST(Layers, AnOutermostLayerShowsAndItsThicknessIsHeight) {
  Scene scene = coated_plate();
  scene.emitters[0].carries = {};
  scene.rules = {wear("1", 1000.0)};  // 62.5 um an iteration: a layer a turn.
  Simulation simulation(scene);
  const SurfaceAtlas& surface = simulation.atlas().surface();
  const auto texel = static_cast<TexelIndex>(
      std::find_if(surface.triangles().begin(), surface.triangles().end(), [](int t) { return t >= 0; }) -
      surface.triangles().begin());
  const auto red = [&] { return static_cast<int>(simulation.compose().codes()[texel] & 255); };
  const int paint = red();
  // A height is rounded to 1/1024 of a texel, twice.
  const double step_mm = simulation.texel_size_mm() / 1024.0;
  EXPECT_NEAR(simulation.compose().height_mm(texel), 0.100, step_mm);
  run_iterations(simulation, 8);
  EXPECT_EQ(simulation.layers()->tops()[texel], kPrimer);
  EXPECT_NEAR(simulation.compose().height_mm(texel), 0.040, step_mm);
  EXPECT_NE(red(), paint);
  run_iterations(simulation, 8);
  EXPECT_EQ(simulation.layers()->tops()[texel], 0);
  EXPECT_NEAR(simulation.compose().height_mm(texel), 0.0, step_mm);
  Scene bare = testing_support::plate_scene(96);
  bare.emitters[0].carries = {};
  Simulation steel(bare);
  EXPECT_EQ(simulation.compose().codes()[texel] & 0xFFFFFF, steel.compose().codes()[texel] & 0xFFFFFF);
}

TEST(Layers, ACoatHasItsPattern) {
  Scene scene = weathered_plate();
  Preset& look = scene.objects[0].layers[kPaint].look;
  look.second_color = Vec3(0.9, 0.1, 0.1);
  look.pattern = "spots";
  Simulation simulation(scene);
  const SurfaceAtlas& surface = simulation.atlas().surface();
  const std::span<const std::uint32_t> codes = simulation.compose().codes();
  int least = 255, most = 0;
  for (TexelIndex t = 0; t < surface.triangles().size(); ++t) {
    if (surface.triangles()[t] < 0) continue;
    const int red = static_cast<int>(codes[t] & 255);
    least = std::min(least, red);
    most = std::max(most, red);
  }
  // sRGB codes of 0.05 and 0.9 linear are 63 and 243; noise of five octaves covers most of [0, 1].
  EXPECT_LT(least, 120);
  EXPECT_GT(most, 200);
}

TEST(Layers, OneThatLostItsAdhesionFallsOffWithWhatLiesOnIt) {
  Scene scene = coated_plate();
  Rule rule{.name = "loosening", .driver = "1", .rate = 1.0, .layer = "primer"};
  rule.layer_reactants.adhesion = 4.0;  // Adhesion 1 in 4 iterations.
  scene.rules = {rule};
  Simulation simulation(scene);
  run_iterations(simulation, 16);
  for (const int layer : {kPrimer, kPaint}) {
    const LayerAccount& account = simulation.layers()->account(0, layer);
    EXPECT_EQ(account.flaked, account.start);
    EXPECT_EQ(account.worn, MassSum{});
  }
  EXPECT_EQ(*std::max_element(simulation.layers()->tops().begin(), simulation.layers()->tops().end()), 0);
}

TEST(Layers, WhatRustedBelowThemLiesBareWhenTheyAreGone) {
  Scene scene = coated_plate();
  scene.emitters[0].is_on = false;
  Rule rusting{.name = "rusting", .driver = "max(0, 0.5 - interface.rust)", .rate = 1.0, .layer = "primer"};
  rusting.layer_products.at_interface[kRust] = 1.0;
  scene.rules = {rusting};
  Simulation simulation(scene);
  run_iterations(simulation, 100);
  const std::int64_t below = simulation.layers()->interface_mass(kRust);
  EXPECT_GT(below, 0);
  EXPECT_EQ(simulation.atlas().mass(kRust), 0);
  const Rule off{.name = "off", .driver = "1", .rate = 1.0, .layer = "primer", .layer_reactants = {.adhesion = 1000.0}};
  simulation.apply(
      {.iteration = 0,
       .what = RuleEvent{.rule = "off",
                         .change = {.driver = {}, .rate = {}, .products = {}, .reactants = {}, .begins = off}}});
  simulation.apply(
      {.iteration = 0,
       .what = RuleEvent{.rule = "rusting",
                         .change = {.driver = {}, .rate = 0.0, .products = {}, .reactants = {}, .begins = {}}}});
  run_iterations(simulation, 8);
  EXPECT_EQ(simulation.layers()->interface_mass(kRust), 0);
  EXPECT_EQ(simulation.atlas().mass(kRust), below);
  EXPECT_EQ(simulation.audit(), "");
}

TEST(Layers, AnEdgeWandersAtTheSpeedThatARuleGives) {
  Scene scene = coated_plate(128);
  ImageF left(64, 64, 1, 0.0F);
  for (int y = 0; y < 64; ++y) {
    for (int x = 32; x < 64; ++x) left.at(x, y) = 1.0F;
  }
  scene.maps.emplace_back() = {.name = "across",
                               .kind = "image",
                               .options = {},
                               .noise = {},
                               .wood_grain = {},
                               .images = {left},
                               .is_inside = {}};
  scene.objects[0].layers[kPaint].thickness_um = "60 * smoothstep(0.49, 0.51, across)";
  constexpr double kSpeed = 0.125;  // mm a unit of time: 128 iterations a mm
  Rule creep{.name = "creep", .driver = "edge", .rate = kSpeed, .layer = "paint"};
  creep.layer_reactants.adhesion = 1.0;
  scene.rules = {creep};
  Simulation simulation(scene);
  const double mm = simulation.texel_size_mm();
  const auto width_mm = [&] {
    std::int64_t gone = 0, all = 0;
    const SurfaceAtlas& surface = simulation.atlas().surface();
    for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
      if (!surface.is_covered(t)) continue;
      ++all;
      gone += simulation.layers()->tops()[t] < kPaint ? 1 : 0;
    }
    return mm * static_cast<double>(gone) / std::sqrt(static_cast<double>(all));
  };
  const double start = width_mm();
  EXPECT_GT(start, 40.0);
  constexpr int kIterations = 1280;
  run_iterations(simulation, kIterations);
  const double way = kSpeed * kIterations * scene.time_per_iteration;
  // A texel's turn comes up to 8 iterations after its neighbor has gone.
  const double iterations_a_texel = mm / (kSpeed * scene.time_per_iteration);
  EXPECT_LE(width_mm() - start, way + mm);
  EXPECT_GE(width_mm() - start, way * iterations_a_texel / (iterations_a_texel + RuleEngine::kEpoch) - mm);
}

TEST(Layers, SleepChangesNothing) {
  // Where rules have nothing to do tiles sleep; what wakes them is that a layer opens beside them.
  Simulation sleeping(weathered_plate()), awake(weathered_plate());
  for (int i = 0; i < 250; ++i) {
    sleeping.step();
    awake.step();
    awake.restore(awake.snapshot());  // Everything is awake.
  }
  EXPECT_EQ(sleeping.state_hash(), awake.state_hash());
}

TEST(Layers, DriversSeeWhatTheyAreMadeOf) {
  // Bare steel is metal, and painted steel is not: the built-in rule rusts what is bare.
  Scene scene = coated_plate();
  scene.objects[0].layers[kPaint].thickness_um = scene.objects[0].layers[kPrimer].thickness_um = "0";
  scene.rules = {testing_support::rust_rule(0.5)};
  Simulation bare(scene);
  run_iterations(bare, 60);
  EXPECT_GT(bare.atlas().mass(kRust), 0);
  Scene plain = testing_support::plate_scene(96);
  plain.emitters[0].gammatons = 300;
  plain.time_per_iteration = scene.time_per_iteration;
  plain.rules = scene.rules;
  Simulation iron(plain);
  run_iterations(iron, 60);
  EXPECT_EQ(bare.atlas().mass(kRust), iron.atlas().mass(kRust));
  EXPECT_EQ(bare.atlas().mass(kMetal), 0);
  scene.objects[0].layers[kPaint].thickness_um = "60";
  Simulation painted(scene);
  run_iterations(painted, 60);
  EXPECT_EQ(painted.atlas().mass(kRust), 0);
}

TEST(Layers, AScaledObjectHasAsManyUmAsBeforeAndItsBooksBalance) {
  Simulation simulation(weathered_plate());
  run_iterations(simulation, 100);
  const std::string before = simulation.layers()->hash();
  simulation.apply({.iteration = 0, .what = ScaleEvent{.object = "plate", .scale = 2.0}});
  EXPECT_EQ(simulation.layers()->hash(), before);
  EXPECT_EQ(simulation.audit(), "");
  run_iterations(simulation, 50);
  EXPECT_EQ(simulation.audit(), "");
}

TEST(Layers, ThatCannotBeAreRefusedInOneLine) {
  const auto says = [](const std::function<void(Scene&)>& change) {
    Scene scene = coated_plate();
    change(scene);
    return error_of([&] { Simulation simulation(scene); });
  };
  const auto many = says([](Scene& s) {
    while (s.objects[0].layers.size() < 9)
      s.objects[0].layers.push_back({.name = "coat" + std::to_string(s.objects[0].layers.size()), .thickness_um = "1"});
  });
  EXPECT_TRUE(has(many, "layers of object 'plate' is 9; use at most 8")) << many;
  const auto twice = says([](Scene& s) { s.objects[0].layers[kPaint].name = "primer"; });
  EXPECT_TRUE(has(twice, "two layers of object 'plate' are called 'primer'")) << twice;
  const auto unknown = says([](Scene& s) {
    s.rules.push_back(wear("1", 1.0));
    s.rules.back().layer = "pant";
  });
  EXPECT_TRUE(has(unknown, "rule 'wear' acts on a layer 'pant'")) << unknown;
  const auto none = says([](Scene& s) {
    s.objects[0].layers.clear();
    s.rules.push_back(wear("1", 1.0));
  });
  EXPECT_TRUE(has(none, "rule 'wear' acts on a layer, and the scene has none")) << none;
  const auto taken = says([](Scene& s) { s.materials[0] = "edge"; });
  EXPECT_TRUE(has(taken, "a material is called 'edge'")) << taken;
  const auto map = says([](Scene& s) { s.objects[0].layers[kPaint].thickness_um = "60 * wornn"; });
  EXPECT_TRUE(has(map, "thickness_um of layer 'paint' of object 'plate'")) << map;
}

}  // namespace
}  // namespace patinate::simulation
