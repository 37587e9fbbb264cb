#include "patinate/simulation/engine.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "patinate/core/error.h"
#include "simulation/tracing/gammatons.h"
#include "tests/simulation/engine/run_iterations.h"
#include "tests/support/errors.h"
#include "tests/support/meshes.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::run_iterations;
using testing_support::rust_rule;

/// The plate with relief of rust, in denser rain that washes a little of it on.
Scene plate(int resolution = 96) {
  Scene scene = testing_support::plate_scene(resolution);
  scene.appearance[2].height_mm = 0.3;
  scene.emitters[0].gammatons = 300;
  scene.emitters[0].spread_deg = 5;
  scene.exchange.rates[2] = 0.02;
  scene.rules.push_back(rust_rule(0.5));
  return scene;
}

TEST(Simulation, BooksBalanceExactlyInEveryIteration) {
  for (const double ratio : {0.0, 0.3, 1.0}) {
    Scene scene = plate();
    scene.exchange.ratio = ratio;
    Simulation simulation(scene);
    for (int i = 0; i < 80; ++i) {
      simulation.step();
      const TraceCounters& c = simulation.counters();
      ASSERT_EQ(c.emitted, c.absorbed + c.left + c.rested + c.alive);
      ASSERT_TRUE(simulation.ledger().balances());
    }
    EXPECT_EQ(simulation.audit(), "");
    EXPECT_GT(simulation.counters().contacts, 1000);
  }
}

TEST(Simulation, RainMakesIronRust) {
  Simulation simulation(plate());
  EXPECT_EQ(simulation.atlas().mass(2), 0);
  run_iterations(simulation, 100);
  EXPECT_GT(simulation.atlas().mass(0), 0);
  EXPECT_GT(simulation.atlas().mass(2), 0);
  EXPECT_EQ(simulation.audit(), "");
}

TEST(Simulation, GivesTheSameBitsForAnyNumberOfThreads) {
  Simulation one(plate());
  run_iterations(one, 60, 1);
  const std::vector<std::byte> expected = one.snapshot();
  for (const int threads : {2, 3, 8}) {
    Simulation other(plate());
    run_iterations(other, 60, threads);
    EXPECT_EQ(other.atlas().hash(), one.atlas().hash());
    EXPECT_TRUE(other.snapshot() == expected) << threads << " threads";
  }
}

TEST(Simulation, LookingChangesNothing) {
  SimulationOptions options;
  options.parameter_maps = {"hits", "water.deposited"};
  Simulation seen(plate(), options), unseen(plate(), options);
  for (int i = 0; i < 50; ++i) {
    seen.step();
    (void)seen.compose();
    (void)seen.snapshot();
    (void)seen.parameter_map("hits");
    (void)seen.dirty_since(i);
  }
  run_iterations(unseen, 50);
  EXPECT_TRUE(seen.snapshot() == unseen.snapshot());
  EXPECT_EQ(seen.compose().color_srgb8(), unseen.compose().color_srgb8());
}

TEST(Simulation, GoesOnFromASnapshotAsIfNothingHadHappened) {
  SimulationOptions options;
  options.parameter_maps = {"hits", "last_hit", "residence", "rust.deposited"};
  Simulation whole(plate(), options);
  run_iterations(whole, 37);
  const std::vector<std::byte> half_way = whole.snapshot();
  run_iterations(whole, 43);
  Simulation resumed(plate(), options);
  run_iterations(resumed, 5);
  resumed.restore(half_way);
  EXPECT_EQ(resumed.iteration(), 37);
  EXPECT_TRUE(resumed.snapshot() == half_way);
  run_iterations(resumed, 43);
  EXPECT_TRUE(resumed.snapshot() == whole.snapshot());
  EXPECT_EQ(resumed.compose().color_srgb8(), whole.compose().color_srgb8());
  EXPECT_EQ(resumed.audit(), "");
}

TEST(Simulation, ASnapshotGoesOnInASceneWithOneMoreEmitterThatWaits) {
  Scene with_brush = plate();
  Emitter brush;
  brush.name = "brush";
  brush.shape = EmitterShape::Surface;
  brush.gammatons = 70;
  brush.size_mm = {20.0, 0.0};
  brush.carries[0] = 2.0;
  brush.is_on = false;
  with_brush.emitters.push_back(brush);
  Simulation finished(plate()), whole(with_brush), resumed(with_brush);
  run_iterations(finished, 25);
  run_iterations(whole, 25);
  resumed.restore(finished.snapshot());
  EXPECT_TRUE(resumed.snapshot() == whole.snapshot());
  const SceneEvent on{.what = SwitchEvent{.emitter = "brush", .is_on = true}};
  whole.apply(on);
  resumed.apply(on);
  run_iterations(whole, 15);
  run_iterations(resumed, 15);
  EXPECT_TRUE(resumed.snapshot() == whole.snapshot());
  EXPECT_EQ(resumed.audit(), "");
  EXPECT_THROW(finished.restore(whole.snapshot()), InvalidInput);  // not the other way
}

TEST(Simulation, ADamagedOrForeignSnapshotIsRefusedAndChangesNothing) {
  Simulation simulation(plate());
  run_iterations(simulation, 10);
  const std::vector<std::byte> good = simulation.snapshot();
  Simulation other(plate(128));
  EXPECT_TRUE(has(error_of([&] { simulation.restore(other.snapshot()); }), "snapshot"));
  for (std::size_t length = 0; length < good.size(); length += good.size() / 50 + 1) {
    EXPECT_THROW(simulation.restore(std::span(good).first(length)), InvalidInput);
  }
  EXPECT_TRUE(simulation.snapshot() == good);
}

TEST(Simulation, ASnapshotWithFlippedBitsIsRefusedOrRuns) {
  Simulation simulation(plate());
  run_iterations(simulation, 10);
  const std::vector<std::byte> good = simulation.snapshot();
  for (std::size_t i = 0; i < 400; ++i) {
    std::vector<std::byte> bad = good;
    bad[i < 200 ? i * 3 : i * (good.size() / 400)] ^= std::byte{0x41};
    try {
      simulation.restore(bad);
      run_iterations(simulation, 2);
    } catch (const InvalidInput&) {
    }
  }
}

TEST(Simulation, EventsOfTheSceneAreWhatAnArtistWouldDo) {
  const SceneEvent move{.iteration = 20, .what = MoveEvent{.target = "plate", .position_mm = Vec3(30, 0, 0)}};
  const SceneEvent ratio{.iteration = 30, .what = RatioEvent{.ratio = 0.1}};
  Scene written = plate();
  written.events = {move, ratio};
  Simulation replayed(written), live(plate());
  run_iterations(replayed, 50);
  run_iterations(live, 20);
  live.apply(move);
  run_iterations(live, 10);
  live.apply(ratio);
  run_iterations(live, 20);
  EXPECT_EQ(live.atlas().hash(), replayed.atlas().hash());
  EXPECT_TRUE(has(error_of([&] {
                    live.apply({.iteration = 20, .what = MoveEvent{.target = "plat", .position_mm = Vec3(30, 0, 0)}});
                  }),
                  "no object called 'plat'"));
}

SceneEvent rule_event(std::int64_t iteration, const std::string& name, RuleChange change) {
  return {.iteration = iteration, .what = RuleEvent{.rule = name, .change = std::move(change)}};
}

/// Dust settles where it is level and open: asks for two maps that no rule of plate() does.
Rule settling_rule() {
  Rule rule{.name = "settling", .driver = "exposure * max(0, 1 - slope)", .rate = 0.3};
  rule.products[2] = 0.5;
  return rule;
}

TEST(Simulation, ChangedRulesAreTheSameAtOnceFromAFileAndAcrossSnapshots) {
  MaterialValues half{}, some{};
  half[2] = 0.5;
  some[0] = 0.2;
  const SceneEvent moved{.iteration = 12, .what = MoveEvent{.target = "plate", .position_mm = Vec3(20, 0, 0)}};
  Scene written = plate();
  written.events = {
      rule_event(11, "rust", {.driver = {}, .rate = 2.0, .products = half, .reactants = some, .begins = {}}), moved,
      rule_event(21, "settling",
                 {.driver = {}, .rate = {}, .products = {}, .reactants = {}, .begins = settling_rule()}),
      rule_event(30, "settling", {.driver = "slope", .rate = {}, .products = {}, .reactants = {}, .begins = {}})};
  Simulation replayed(written), live(plate());
  std::vector<std::byte> half_way;
  for (int i = 0; i < 45; ++i) {
    for (const SceneEvent& event : written.events) {
      if (event.iteration == i) live.apply(event);
    }
    run_iterations(live, 1);
    run_iterations(replayed, 1);
    if (i == 25) half_way = replayed.snapshot();
  }
  EXPECT_EQ(live.atlas().hash(), replayed.atlas().hash());
  ASSERT_EQ(live.scene().rules.size(), 2U);
  EXPECT_EQ(live.scene().rules[0].rate, 2.0);
  EXPECT_EQ(live.scene().rules[1].driver, "slope");
  Simulation resumed(written);  // its plate stands elsewhere when the maps of the new rule are made again
  resumed.restore(half_way);
  run_iterations(resumed, 19);
  EXPECT_TRUE(resumed.snapshot() == replayed.snapshot());
  EXPECT_EQ(resumed.audit(), "");
  Simulation back(written);
  const std::vector<std::byte> start = back.snapshot();
  run_iterations(back, 45);
  back.restore(start);
  EXPECT_EQ(back.scene().rules.size(), 1U);
  run_iterations(back, 45);
  EXPECT_EQ(back.atlas().hash(), replayed.atlas().hash());
}

TEST(Simulation, ARuleOfAlphaZeroMakesNothingMore) {
  Simulation simulation(plate());
  run_iterations(simulation, 30);
  const MassSum made = simulation.ledger().account(2).made;
  EXPECT_GT(made.value(), 0.0);
  simulation.apply(rule_event(0, "rust", {.driver = {}, .rate = 0.0, .products = {}, .reactants = {}, .begins = {}}));
  run_iterations(simulation, 30);
  EXPECT_EQ(simulation.ledger().account(2).made.value(), made.value());
  simulation.apply(rule_event(0, "rust", {.driver = {}, .rate = 0.5, .products = {}, .reactants = {}, .begins = {}}));
  run_iterations(simulation, 10);
  EXPECT_GT(simulation.ledger().account(2).made.value(), made.value());
}

TEST(Simulation, ARuleThatCannotBeIsRefusedAndChangesNothing) {
  Simulation simulation(plate());
  run_iterations(simulation, 10);
  const std::vector<std::byte> before = simulation.snapshot();
  const auto refused = [&](const std::string& name, RuleChange change) {
    return error_of([&] { simulation.apply(rule_event(0, name, std::move(change))); });
  };
  EXPECT_TRUE(has(refused("rusty", {.driver = {}, .rate = 1.0, .products = {}, .reactants = {}, .begins = {}}),
                  "no rule called 'rusty'"));
  EXPECT_TRUE(
      has(refused("rust", {.driver = "min(water, gold)", .rate = {}, .products = {}, .reactants = {}, .begins = {}}),
          "gold"));
  EXPECT_TRUE(has(refused("rust", {.driver = {}, .rate = -1.0, .products = {}, .reactants = {}, .begins = {}}),
                  "rate of rule 'rust'"));
  EXPECT_TRUE(simulation.snapshot() == before);
  Scene twins = plate();
  twins.rules.push_back(rust_rule(0.5));
  Simulation two(twins);
  EXPECT_TRUE(has(error_of([&] {
                    two.apply(rule_event(0, "rust",
                                         {.driver = {}, .rate = 1.0, .products = {}, .reactants = {}, .begins = {}}));
                  }),
                  "two rules are called 'rust'"));
}

TEST(Simulation, AnEmitterThatIsSwitchedOffEmitsNoMore) {
  const auto rain = [](bool is_on) { return SceneEvent{.what = SwitchEvent{.emitter = "rain", .is_on = is_on}}; };
  Simulation simulation(plate());
  run_iterations(simulation, 10);
  simulation.apply(rain(false));
  const std::int64_t emitted = simulation.counters().emitted;
  run_iterations(simulation, 10);
  EXPECT_EQ(simulation.counters().emitted, emitted);
  simulation.apply(rain(true));
  run_iterations(simulation, 10);
  EXPECT_GT(simulation.counters().emitted, emitted);
  EXPECT_TRUE(
      has(error_of([&] { simulation.apply({.what = SwitchEvent{.emitter = "rian"}}); }), "no emitter called 'rian'"));
}

TEST(Simulation, DirtyTilesAreThoseThatChanged) {
  Simulation simulation(plate());
  run_iterations(simulation, 20);
  const Composer& before = simulation.compose();
  std::vector<std::uint32_t> codes(before.codes().begin(), before.codes().end());
  simulation.step();
  const std::vector<TileIndex> dirty = simulation.dirty_since(20);
  EXPECT_FALSE(dirty.empty());
  const Composer& after = simulation.compose();
  for (TexelIndex t = 0; t < codes.size(); ++t) {
    if (std::binary_search(dirty.begin(), dirty.end(), TileGrid::tile_of(t))) continue;
    EXPECT_EQ(after.codes()[t], codes[t]);
  }
}

TEST(Simulation, HitsTimesAreaAreOneAContact) {
  SimulationOptions options;
  options.parameter_maps = {"hits"};
  Simulation simulation(plate(), options);
  run_iterations(simulation, 40);
  double sum = 0.0;
  const ParameterMap hits = simulation.parameter_map("hits");
  const SurfaceAtlas& surface = simulation.atlas().surface();
  for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    const float hits_per_mm2 = hits.values.at(surface.grid().x(t), surface.grid().y(t));
    sum += std::round(static_cast<double>(hits_per_mm2) * surface.area_mm2(t));
  }
  EXPECT_EQ(hits.unit, "1/mm2");
  EXPECT_LE(sum, static_cast<double>(simulation.counters().contacts));
  EXPECT_GT(sum,
            0.95 * static_cast<double>(simulation.counters().contacts));  // a contact beside every texel counts nowhere
  EXPECT_TRUE(has(error_of([&] { (void)simulation.parameter_map("residence"); }), "was not asked for"));
}

TEST(Simulation, AParameterMapOfNoKnownNameIsRefusedWithTheKnownOnes) {
  const auto asked_for = [](const std::string& name) {
    return error_of([&] { const Simulation simulation(plate(), {.parameter_maps = {"hits", name}}); });
  };
  for (const std::string& material : plate().materials) {
    EXPECT_EQ(asked_for(material + ".deposited"), "");
    EXPECT_EQ(asked_for(material + ".final"), "");
  }
  for (const std::string name : {"hist", "rust", "rust.deposit", "", "Hits", "lead.deposited"}) {
    EXPECT_TRUE(
        has(asked_for(name), "there is no parameter map '" + name + "'; use one of hits, last_hit, residence, "))
        << name;
  }
  EXPECT_TRUE(has(asked_for("rust.deposit"), "; did you mean `rust.deposited`?"));
  Simulation simulation(plate());
  EXPECT_TRUE(has(error_of([&] { (void)simulation.parameter_map("hist"); }), "there is no parameter map 'hist'"));
}

TEST(Simulation, WithoutRatesHitsAreCountedAndNothingIsExchanged) {
  Scene scene = plate();
  scene.exchange = {};
  SimulationOptions options;
  options.parameter_maps = {"hits"};
  Simulation simulation(scene, options);
  const std::string before = simulation.atlas().hash();
  run_iterations(simulation, 20);
  EXPECT_GT(simulation.counters().contacts, 500);
  EXPECT_EQ(simulation.atlas().hash(), before);
}

TEST(Simulation, OtherLooksChangeNoAmounts) {
  Simulation simulation(plate());
  run_iterations(simulation, 60);
  const std::string hash = simulation.atlas().hash();
  const ImageU8 rusty = simulation.compose().color_srgb8();
  std::vector<MaterialAppearance> appearance = simulation.scene().appearance;
  for (MaterialAppearance& look : appearance) look.strength = 0.0;
  simulation.set_appearance(appearance);
  EXPECT_NE(simulation.compose().color_srgb8(), rusty);
  simulation.set_appearance(plate().appearance);
  EXPECT_EQ(simulation.compose().color_srgb8(), rusty);
  EXPECT_EQ(simulation.atlas().hash(), hash);
}

TEST(Simulation, ASceneWithoutEmittersIsRefused) {
  Scene scene = plate();
  scene.emitters.clear();
  EXPECT_TRUE(has(error_of([&] { Simulation s(scene); }), "no emitters"));
}

}  // namespace
}  // namespace patinate::simulation
