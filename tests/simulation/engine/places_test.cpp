// Objects that are moved, turned and scaled while a simulation runs.
#include <gtest/gtest.h>

#include <numeric>

#include "patinate/core/error.h"
#include "patinate/simulation/engine.h"
#include "simulation/tracing/gammatons.h"
#include "tests/simulation/engine/run_iterations.h"
#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::plate_scene;
using testing_support::run_iterations;
using testing_support::rust_rule;

Scene rusting_plate() {
  Scene scene = plate_scene(96);
  scene.exchange.rates[2] = 0.02;
  scene.rules.push_back(rust_rule(0.5));
  return scene;
}

constexpr int kEpoch = 8;  // iterations: of rules

SceneEvent scaled(double scale, std::int64_t iteration = 0) {
  return {.iteration = iteration, .what = ScaleEvent{.object = "plate", .scale = scale}};
}

/// Area of a plate of which a contact map is even.
double contacts_times_area(const Simulation& simulation, double mm2_a_texel) {
  const ImageF hits = simulation.parameter_map("hits").values;
  return mm2_a_texel * std::accumulate(hits.values().begin(), hits.values().end(), 0.0);
}

TEST(Places, AnObjectThatGrowsKeepsItsAmountsAndTheBooksBalance) {
  Simulation simulation(rusting_plate(), {.parameter_maps = {"hits"}});
  run_iterations(simulation, 40);
  const std::string amounts = simulation.atlas().hash();
  const std::int64_t mass = simulation.atlas().mass(2);
  const double made = simulation.ledger().account(2).made.value();
  ASSERT_GT(mass, 0);
  simulation.apply(scaled(2.0));
  EXPECT_EQ(simulation.atlas().hash(), amounts);
  EXPECT_EQ(simulation.atlas().mass(2), 4 * mass) << "four times the area";
  EXPECT_EQ(simulation.ledger().account(2).made.value() - made, 3.0 * static_cast<double>(mass));
  EXPECT_EQ(simulation.audit(), "");
  run_iterations(simulation, 40);
  EXPECT_EQ(simulation.audit(), "");
  // Texels of 4 * (100 / 96)^2 mm2, as the map has them.
  const double texel = 100.0 / 96.0;
  EXPECT_NEAR(contacts_times_area(simulation, 4.0 * texel * texel), static_cast<double>(simulation.counters().contacts),
              0.01 * static_cast<double>(simulation.counters().contacts));
  simulation.apply(scaled(1.0));
  EXPECT_EQ(simulation.audit(), "");
}

TEST(Places, GoOnFromASnapshotAsIfNothingHadHappened) {
  Scene scene = rusting_plate();
  scene.rules.push_back({.name = "dirt", .driver = "slope + exposure", .rate = 0.3, .products = {0, 0, 1}});
  scene.events = {scaled(2.0, 10),
                  {.iteration = 15, .what = MoveEvent{.target = "plate", .position_mm = Vec3(20, -5, 0)}},
                  {.iteration = 15, .what = TurnEvent{.object = "plate", .rotate_deg = Vec3(0, 0, 40)}},
                  scaled(0.5, 25)};
  Simulation whole(scene);
  run_iterations(whole, 40);
  for (const int cut : {5, 15, 20}) {
    Simulation first(scene), second(scene);
    run_iterations(first, cut);
    second.restore(first.snapshot());
    run_iterations(second, 40 - cut);
    EXPECT_EQ(second.atlas().hash(), whole.atlas().hash()) << "cut at " << cut;
    EXPECT_EQ(second.audit(), "");
    EXPECT_EQ(second.snapshot(), whole.snapshot()) << "cut at " << cut;
  }
}

TEST(Places, ASlopeThatARuleAsksForIsThatOfTheObjectAsItStandsNow) {
  Scene scene = plate_scene(96);
  scene.emitters[0].is_on = false;
  scene.objects[0].rotate_deg = {0, 0, 0};
  scene.rules = {{.name = "walls", .driver = "slope", .rate = 1.0, .products = {0, 0, 1}}};
  const auto grown_after_turn = [&](const Vec3& from, const Vec3& to) {
    scene.objects[0].rotate_deg = from;
    Simulation simulation(scene);
    run_iterations(simulation, kEpoch);
    simulation.apply({.iteration = 0, .what = TurnEvent{.object = "plate", .rotate_deg = to}});
    run_iterations(simulation, kEpoch);  // times of rules overlap by an epoch
    const std::int64_t before = simulation.atlas().mass(2);
    run_iterations(simulation, 40);
    return simulation.atlas().mass(2) - before;
  };
  const Vec3 one(-60, 0, 0), other(20, 0, 0);
  const std::int64_t in_one = grown_after_turn(one, one), in_other = grown_after_turn(other, other);
  ASSERT_GT(std::abs(in_one - in_other), in_one / 20);
  // Rounding is right in the mean: 9216 texels, 40 times.
  EXPECT_NEAR(static_cast<double>(grown_after_turn(one, other)), static_cast<double>(in_other),
              0.001 * static_cast<double>(in_other));
}

TEST(Places, AScaleBeyondWhatTheAtlasCanTellIsRefusedAtOnce) {
  Scene scene = rusting_plate();
  scene.events = {scaled(9.0, 1000)};
  EXPECT_TRUE(has(error_of<InvalidInput>([&] { Simulation{scene}; }), "object 'plate' would be scaled to 9 times"));
  scene.events.clear();
  Simulation simulation(scene);
  EXPECT_TRUE(has(error_of<InvalidInput>([&] { simulation.apply(scaled(0.1)); }), "0.1 times"));
  EXPECT_EQ(simulation.scene().objects[0].scale, 1.0);
}

}  // namespace
}  // namespace patinate::simulation
