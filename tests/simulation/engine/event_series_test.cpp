// Events that come again and again.
#include <gtest/gtest.h>

#include "patinate/simulation/engine.h"
#include "simulation/tracing/gammatons.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

std::vector<std::int64_t> due_in(const EventSeries& series, std::int64_t end) {
  std::vector<std::int64_t> due;
  for (std::int64_t i = 0; i < end; ++i) {
    if (series.is_due(i)) due.push_back(i);
  }
  return due;
}

TEST(EventSeries, IsDueAtTheIterationsNearestToItsTimes) {
  EXPECT_EQ(due_in({.first = 3, .every = 4, .count = 3, .what = RatioEvent{}}, 40),
            (std::vector<std::int64_t>{3, 7, 11}));
  EXPECT_EQ(due_in({.first = 0.4, .every = 2.5, .count = 5, .what = RatioEvent{}}, 40),
            (std::vector<std::int64_t>{0, 3, 5, 8, 10}));
  const EventSeries odd{.first = 1e-3, .every = 1.0 / 0.3, .what = RatioEvent{}};
  EXPECT_EQ(due_in(odd, 100'000).size(), 30'000u);  // never twice, none left out
}

Scene showers() {
  Scene scene = testing_support::plate_scene(64);
  scene.emitters[0].is_on = false;
  scene.series = {{.first = 7, .every = 10, .what = SwitchEvent{.emitter = "rain", .is_on = false}},
                  {.first = 2, .every = 10, .what = SwitchEvent{.emitter = "rain", .is_on = true}}};
  return scene;
}

TEST(EventSeries, DoesWhatTheSameEventsDoOneByOne) {
  Scene listed = showers();
  listed.series.clear();
  for (std::int64_t i = 2; i < 100; i += 10) {
    listed.events.push_back({i, SwitchEvent{.emitter = "rain", .is_on = true}});
    listed.events.push_back({i + 5, SwitchEvent{.emitter = "rain", .is_on = false}});
  }
  Simulation a(showers()), b(listed);
  for (int i = 0; i < 100; ++i) {
    a.step();
    b.step();
    ASSERT_EQ(a.counters(), b.counters()) << i;
  }
  EXPECT_EQ(a.atlas().hash(), b.atlas().hash());
  EXPECT_GT(a.counters().emitted, 0);
}

TEST(EventSeries, HappensOnceAlsoWhenItIsAskedForBeforeAStep) {
  Scene scene = testing_support::plate_scene(64);
  Emitter brush;
  brush.name = "brush";
  brush.shape = EmitterShape::Surface;
  brush.gammatons = 80;
  brush.carries[0] = 1.0;
  brush.is_on = false;
  scene.emitters.push_back(brush);
  scene.series = {
      {.first = 1, .every = 3, .what = PaintEvent{.emitter = "brush", .stops = {{.position_mm = Vec3(0, 0, 0)}}}}};
  Simulation asked(scene), plain(scene);
  for (int i = 0; i < 20; ++i) {
    asked.apply_due();
    const std::vector<std::byte> state = asked.snapshot();  // after the series, before the step
    asked.restore(state);
    asked.apply_due();
    asked.step();
    plain.step();
  }
  EXPECT_EQ(asked.num_paint_steps(), 7);
  EXPECT_TRUE(asked.snapshot() == plain.snapshot());
}

}  // namespace
}  // namespace patinate::simulation
