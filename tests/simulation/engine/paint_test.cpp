// A brush that paints alone: Simulation::paint() and the event `paint`.
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"
#include "patinate/simulation/engine.h"
#include "simulation/files/scene_json.h"
#include "simulation/tracing/gammatons.h"
#include "tests/simulation/engine/run_iterations.h"
#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::run_iterations;

constexpr std::int64_t kBrushGammatons = 70;

/// Iron in the rain that rusts, and a brush that waits.
Scene painted_plate() {
  Scene scene = testing_support::plate_scene(96);
  scene.exchange.rates[2] = 0.02;
  scene.rules.push_back(testing_support::rust_rule(0.5));
  Emitter brush;
  brush.name = "brush";
  brush.shape = EmitterShape::Surface;
  brush.gammatons = kBrushGammatons;
  brush.size_mm = {20.0, 0.0};
  brush.carries[0] = 2.0;
  brush.is_on = false;
  scene.emitters.push_back(brush);
  return scene;
}

/// Left to right over the middle of the plate, with a rest.
std::vector<BrushStop> stroke() {
  std::vector<BrushStop> stops;
  for (double x = -30.0; x <= 30.0; x += 5.0)
    stops.push_back({.position_mm = Vec3(x, 0, 0), .steps = x == 0.0 ? 4 : 1});
  return stops;
}

void paint(Simulation& simulation, const std::vector<BrushStop>& stops, int num_threads = 0) {
  for (const BrushStop& stop : stops) {
    for (std::int64_t i = 0; i < stop.steps; ++i)
      simulation.paint("brush", stop.position_mm, {.on_progress = {}, .stop = {}, .num_threads = num_threads});
  }
}

TEST(Paint, LeavesTimeRulesAndAllOtherGammatonsWhereTheyAre) {
  Simulation simulation(painted_plate());
  run_iterations(simulation, 30);
  const Gammatons before = simulation.gammatons();
  const std::int64_t rust = simulation.atlas().mass(2), water = simulation.atlas().mass(0);
  const MassLedger ledger = simulation.ledger();
  paint(simulation, stroke());
  EXPECT_EQ(simulation.iteration(), 30);
  EXPECT_EQ(simulation.num_paint_steps(), 16);
  EXPECT_GT(simulation.atlas().mass(0), water);
  EXPECT_EQ(simulation.ledger().account(2).made.value(), ledger.account(2).made.value());
  EXPECT_EQ(simulation.atlas().mass(2) > rust, false);  // drops may take rust along; none is made
  const Gammatons& after = simulation.gammatons();
  for (std::size_t i = 0; i + kBrushGammatons < before.size(); ++i) {
    ASSERT_EQ(after.state[i], before.state[i]) << i;
    ASSERT_EQ(after.num_births[i], before.num_births[i]) << i;
    ASSERT_EQ(after.position[i], before.position[i]) << i;
    ASSERT_EQ(after.velocity[i], before.velocity[i]) << i;
  }
  const TraceCounters& c = simulation.counters();
  EXPECT_EQ(c.emitted, c.absorbed + c.left + c.rested + c.alive);
  EXPECT_EQ(simulation.audit(), "");
}

TEST(Paint, GivesTheSameBitsForAnyNumberOfThreads) {
  Simulation one(painted_plate());
  run_iterations(one, 10);
  paint(one, stroke(), 1);
  run_iterations(one, 10);
  for (const int threads : {2, 7}) {
    Simulation other(painted_plate());
    run_iterations(other, 10);
    paint(other, stroke(), threads);
    run_iterations(other, 10);
    EXPECT_TRUE(other.snapshot() == one.snapshot()) << threads << " threads";
  }
}

TEST(Paint, AnEventOfAFileGivesTheBytesOfTheCallsThatItRecords) {
  Simulation live(painted_plate(), {.parameter_maps = {"hits", "residence"}});
  run_iterations(live, 12);
  paint(live, stroke());
  paint(live, stroke());
  run_iterations(live, 8);
  Scene scene = painted_plate();
  for (int i = 0; i < 2; ++i)
    scene.events.push_back({.iteration = 12, .what = PaintEvent{.emitter = "brush", .stops = stroke()}});
  Simulation replayed(scene, {.parameter_maps = {"hits", "residence"}});
  run_iterations(replayed, 20);
  EXPECT_EQ(replayed.atlas().hash(), live.atlas().hash());
  EXPECT_EQ(replayed.parameter_map("residence").values, live.parameter_map("residence").values);
  Simulation at_its_end(scene);
  run_iterations(at_its_end, 12);
  const std::uint64_t steps = static_cast<std::uint64_t>(at_its_end.num_paint_steps());
  EXPECT_EQ(steps, 0u);
  at_its_end.apply_due();  // a run that ends here has the strokes in its picture, and continues to the same bytes
  EXPECT_EQ(at_its_end.num_paint_steps(), 32);
  run_iterations(at_its_end, 8);
  EXPECT_EQ(at_its_end.atlas().hash(), live.atlas().hash());
}

TEST(Paint, EveryPlaceOfAStrokeGetsAsManyGammatons) {
  Simulation simulation(painted_plate());
  run_iterations(simulation, 30);
  std::int64_t before = simulation.counters().emitted;
  for (int step = 0; step < 60; ++step) {  // Fast: no place is met twice.
    simulation.paint("brush", Vec3(-30.0 + step, 0, 0));
    const std::int64_t born = simulation.counters().emitted - before;
    EXPECT_GE(born, kBrushGammatons / 8) << step;
    EXPECT_LE(born, kBrushGammatons / 8 + 1) << step;
    before += born;
  }
  const TraceCounters& c = simulation.counters();
  EXPECT_EQ(c.emitted, c.absorbed + c.left + c.rested + c.alive);
  EXPECT_EQ(simulation.audit(), "");
}

TEST(Paint, StepsAtOnePlaceRollDiceOfTheirOwn) {
  // Which drops are absorbed, of those that every eighth step gives birth to: with the same random numbers in every
  // step, always the same.
  Scene scene = painted_plate();
  scene.behavior = {
      .bounce = 0.25, .floating = 0.25, .absorb = 0.5, .deceleration_bounce = 0.4, .deceleration_float = 0.3};
  Simulation simulation(scene);
  const auto absorbed_after = [&](int steps) {
    for (int i = 0; i < steps; ++i) simulation.paint("brush", Vec3(0, 0, 0));
    const Gammatons& g = simulation.gammatons();
    std::vector<bool> is_gone;
    for (std::size_t i = g.size() - kBrushGammatons; i < g.size(); ++i)
      is_gone.push_back(g.state[i] == GammatonState::Waiting);
    return is_gone;
  };
  EXPECT_NE(absorbed_after(16), absorbed_after(8));  // 70 drops that meet a chance of one half: 2^-70 to be equal.
}

TEST(Paint, ASnapshotBetweenStrokesGoesOnAsIfNothingHadHappened) {
  Simulation whole(painted_plate());
  run_iterations(whole, 5);
  paint(whole, stroke());
  const std::vector<std::byte> between = whole.snapshot();
  paint(whole, stroke());
  run_iterations(whole, 5);
  Simulation resumed(painted_plate());
  resumed.restore(between);
  EXPECT_EQ(resumed.num_paint_steps(), 16);
  paint(resumed, stroke());
  run_iterations(resumed, 5);
  EXPECT_TRUE(resumed.snapshot() == whole.snapshot());
}

/// A snapshot of painted_plate() as versions before "PPATSN04" wrote it: no weather, no series, no masks. @param bytes
/// Without its tail.
std::vector<std::byte> before_weather(std::vector<std::byte> bytes, const char* magic, bool has_paint_steps) {
  constexpr std::size_t kPaintSteps = 24;            // behind magic, resolution, number of materials and iteration
  constexpr std::size_t kSeries = kPaintSteps + 16;  // behind the next event
  constexpr std::size_t kEmitters = kSeries + 8 + 7 * 8 + 8;  // behind the place of one object and a count
  constexpr std::size_t kEmitter = 4 + 6 * 8 + 5 * 8 + kMaxMaterials * 8 + 1, kFollows = 4 + 8;
  const Rule rule = testing_support::rust_rule(0.5);
  const std::size_t rules = kEmitters + 2 * (kEmitter + kFollows) + 6 * 8 + kMaxMaterials * 8 + 8;
  const std::size_t where = rules + 8 + rule.name.size() + 8 + rule.driver.size() + 8 + 2 * kMaxMaterials * 8;
  const auto cut = [&](std::size_t from, std::size_t count) {
    bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(from),
                bytes.begin() + static_cast<std::ptrdiff_t>(from + count));
  };
  cut(where, 8);  // of an empty text: from the back, so that places in front hold
  cut(kEmitters + kEmitter + kFollows + kEmitter, kFollows);
  cut(kEmitters + kEmitter, kFollows);
  cut(kSeries, 8);
  if (!has_paint_steps) cut(kPaintSteps, 8);
  for (std::byte* place : {bytes.data(), bytes.data() + bytes.size() - 8}) std::memcpy(place, magic, 8);
  return bytes;
}

TEST(Paint, SnapshotsFromBeforeThereWasPaintingOrWeatherAreRead) {
  Simulation simulation(painted_plate());
  run_iterations(simulation, 5);
  ASSERT_TRUE(simulation.met());
  const std::vector<std::byte> now = simulation.snapshot();
  // Before the magic at the end: trails, which are their number and 17 words each, and a bit for each texel that was
  // met, 64 after their number of tiles.
  const std::size_t trails = 8 + simulation.gammatons().size() * 17 * 4;
  const std::size_t met = 8 + simulation.atlas().surface().grid().num_tiles() * 8;
  const auto without_tail = [](std::vector<std::byte> snapshot, std::size_t length) {
    snapshot.erase(snapshot.end() - 8 - static_cast<std::ptrdiff_t>(length), snapshot.end() - 8);
    return snapshot;
  };
  const std::vector<std::byte> rest = without_tail(now, trails + met);
  const auto with_magic_removed = [](std::vector<std::byte> snapshot) {
    return std::vector<std::byte>(snapshot.begin() + 8, snapshot.end() - 8);
  };
  for (const char* magic : {"PPATSN02", "PPATSN03", "PPATSN04"}) {
    const bool has_weather = std::string_view(magic) == "PPATSN04";
    std::vector<std::byte> old = has_weather ? without_tail(now, met) : rest;
    if (has_weather) {
      for (std::byte* place : {old.data(), old.data() + old.size() - 8}) std::memcpy(place, magic, 8);
    } else {
      old = before_weather(old, magic, std::string_view(magic) == "PPATSN03");
    }
    Simulation restored(painted_plate());
    restored.restore(old);
    EXPECT_FALSE(restored.met()) << magic;
    EXPECT_TRUE(with_magic_removed(without_tail(restored.snapshot(), trails + 8)) == with_magic_removed(rest)) << magic;
  }
}

TEST(Paint, NamesWhatCannotPaint) {
  Simulation simulation(painted_plate());
  EXPECT_TRUE(has(error_of([&] { simulation.paint("rain", Vec3(0, 0, 0)); }), "whole sky"));
  EXPECT_TRUE(has(error_of([&] { simulation.paint("nobody", Vec3(0, 0, 0)); }), "no emitter called 'nobody'"));
  EXPECT_TRUE(has(error_of([&] { simulation.paint("brush", Vec3(0, std::nan(""), 0)); }), "must be finite"));
  EXPECT_EQ(simulation.num_paint_steps(), 0);
}

TEST(Paint, EventsAreReadWithTheirUnitAndRefusedWithAReason) {
  const Scene scene = painted_plate();
  SceneContext context;
  context.materials = scene.materials;
  context.mm_per_unit = 10.0;
  const auto read = [&](const char* points) {
    const Json events =
        Json::parse(std::string(R"([{"iteration": 3, "op": "paint", "target": "brush", "points": )") + points + "}]");
    Scene with_events = scene;
    read_events(JsonReader("scene.json", events, "/events"), context, with_events);
    return with_events.events;
  };
  const std::vector<SceneEvent> events = read("[[1, 2, 3], [0, 0, 0.5, 12]]");
  ASSERT_EQ(events.size(), 1u);
  const std::vector<BrushStop>& stops = std::get<PaintEvent>(events[0].what).stops;
  ASSERT_EQ(stops.size(), 2u);
  EXPECT_EQ(stops[0].position_mm, Vec3(10, 20, 30));
  EXPECT_EQ(stops[0].steps, 1);
  EXPECT_EQ(stops[1].steps, 12);
  for (const char* points : {"[]", "[[1, 2]]", "[[1, 2, 3, 0]]", "[[1, 2, 3, 4, 5]]", "[[1, 2, \"x\"]]",
                             "[[1, 2, 3, 1000000], [1, 2, 3]]", "7"}) {
    EXPECT_TRUE(has(error_of([&] { (void)read(points); }), "/events/0/points")) << points;
  }
}

}  // namespace
}  // namespace patinate::simulation
