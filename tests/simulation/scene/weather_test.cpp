#include "patinate/simulation/weather.h"

#include <gtest/gtest.h>

#include <cmath>

#include "patinate/simulation/engine.h"
#include "simulation/tracing/gammatons.h"
#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;

constexpr double kRounding = 1e-12;
constexpr std::size_t kRain = static_cast<std::size_t>(WeatherSignal::Rain);
constexpr std::size_t kWind = static_cast<std::size_t>(WeatherSignal::Wind);

/// Rain of 2 until 1, 5 until 4, then none.
Weather showers(double repeat = 0.0) {
  Weather weather;
  weather.rows = {{.time = 0, .values = {2}}, {.time = 1, .values = {5}}, {.time = 4, .values = {0}}};
  weather.is_given[kRain] = true;
  weather.repeat = repeat;
  return weather;
}

double rain_over(const Weather& weather, double begin, double end) {
  return mean_weather(weather, begin, end).values[kRain];
}

TEST(Weather, MeansAreThoseOfThePiecesBetweenRows) {
  const Weather w = showers();
  EXPECT_NEAR(rain_over(w, 0, 1), 2.0, kRounding);
  EXPECT_NEAR(rain_over(w, 0, 2), 3.5, kRounding);
  EXPECT_NEAR(rain_over(w, 0.5, 4.5), (0.5 * 2 + 3 * 5) / 4.0, kRounding);
  EXPECT_NEAR(rain_over(w, 3, 13), 0.5, kRounding);
  EXPECT_EQ(rain_over(w, 100, 101), 0.0);
  EXPECT_EQ(rain_over(w, 1, 1), 5.0);  // a moment
}

TEST(Weather, BeginsAgainWhenItRepeats) {
  const Weather w = showers(10.0);
  const double once = (2.0 + 15.0) / 10.0;
  EXPECT_NEAR(rain_over(w, 0, 10), once, kRounding);
  EXPECT_NEAR(rain_over(w, 0, 1000), once, kRounding);
  EXPECT_NEAR(rain_over(w, 20.5, 21.5), 3.5, kRounding);
  EXPECT_NEAR(rain_over(w, 9, 12), (0 + 2 + 5) / 3.0, kRounding);
  EXPECT_NEAR(rain_over(w, 3, 34), (5 + 0 * 6 + 2 * 17 + 2 + 3 * 5) / 31.0, kRounding);
}

TEST(Weather, WindComesFromItsDirection) {
  Weather w;
  w.rows = {{.time = 0, .values = {0, 0, 0, 0, 4}, .wind_from_deg = 0},    // from the north: southward
            {.time = 1, .values = {0, 0, 0, 0, 2}, .wind_from_deg = 90}};  // from the east: westward
  w.is_given[kWind] = true;
  const WeatherMean north = mean_weather(w, 0, 1), both = mean_weather(w, 0, 2);
  EXPECT_NEAR(north.wind_north_m_s, -4.0, kRounding);
  EXPECT_NEAR(north.wind_east_m_s, 0.0, kRounding);
  EXPECT_NEAR(both.wind_north_m_s, -2.0, kRounding);
  EXPECT_NEAR(both.wind_east_m_s, -1.0, kRounding);
  EXPECT_NEAR(both.values[kWind], 3.0, kRounding);  // of the speed, whatever the direction
}

TEST(Weather, SaysWhichValueCannotBe) {
  const auto says = [](WeatherRow row, double repeat = 0.0) {
    Weather w;
    w.rows = {{.time = 1}, row};
    w.repeat = repeat;
    return error_of([&] { check_weather(w); });
  };
  EXPECT_EQ(says({.time = 2}), "");
  EXPECT_EQ(says({.time = 1}), "the time of the weather is 1 after 1; rows go by time");
  EXPECT_TRUE(has(says({.time = 2, .values = {-1}}), "the rain is -1; use [0, 10000] mm/h"));
  EXPECT_TRUE(has(says({.time = 2, .values = {0, 0, 101}}), "the humidity is 101; use [0, 100] %"));
  EXPECT_TRUE(has(says({.time = 2, .values = {0, std::nan("")}}), "the temperature is nan"));
  EXPECT_TRUE(has(says({.time = 2}, 2.0), "repeats after 2; use more than the time of its last row, 2"));
}

/// The plate in a rain that follows the weather; an iteration is 0.05.
Scene plate_in(const Weather& weather) {
  Scene scene = testing_support::plate_scene(64);
  scene.weather = weather;
  scene.emitters[0].follows = WeatherSignal::Rain;
  return scene;
}

TEST(Weather, DropsAreBornInProportionToTheRain) {
  Simulation simulation(plate_in(showers()));  // 200 gammatons; 5 mm/h is all of them
  simulation.step();
  EXPECT_EQ(simulation.counters().emitted, 80);
  for (int i = 1; i < 20; ++i) simulation.step();
  EXPECT_LE(simulation.counters().alive, 80);
  simulation.step();  // from 1.0 to 1.05
  EXPECT_GE(simulation.counters().alive, 120);
  for (int i = 21; i < 80; ++i) simulation.step();
  const std::int64_t emitted = simulation.counters().emitted;
  for (int i = 80; i < 100; ++i) simulation.step();
  EXPECT_EQ(simulation.counters().emitted, emitted) << "it rains no longer";
  EXPECT_EQ(simulation.audit(), "");
}

TEST(Weather, FullAtSaysAtWhichRainAllDropsAreBorn) {
  Scene scene = plate_in(showers());
  scene.emitters[0].full_at = 20.0;
  Simulation simulation(scene);
  simulation.step();
  EXPECT_EQ(simulation.counters().emitted, 20);
}

TEST(Weather, SteadyRainThatIsFollowedIsTheRainThatIsNot) {
  Weather steady;
  steady.rows = {{.time = 0, .values = {3}}};
  steady.is_given[kRain] = true;
  Scene plain = testing_support::plate_scene(64);
  Simulation followed(plate_in(steady)), alone(plain);
  for (int i = 0; i < 60; ++i) {
    followed.step();
    alone.step();
  }
  EXPECT_EQ(followed.atlas().hash(), alone.atlas().hash());
}

TEST(Weather, WindTiltsTheRainThatFollowsIt) {
  Weather w;
  w.rows = {{.time = 0, .values = {1, 0, 0, 0, 0.5}, .wind_from_deg = 270}};  // from the west, along +x
  w.is_given[kRain] = w.is_given[kWind] = true;
  Scene scene = plate_in(w);
  scene.gravity_mm_s2 = Vec3(0, -1e-6, 0);  // straight ways
  scene.behavior = {.bounce = 0, .floating = 0, .absorb = 1};
  Simulation simulation(scene);
  simulation.step();
  int num_absorbed = 0;
  const Gammatons& g = simulation.gammatons();
  for (std::size_t i = 0; i < g.size(); ++i) {
    if (g.num_births[i] == 0 || g.state[i] != GammatonState::Waiting || g.velocity[i].y() == 0.0) continue;
    ++num_absorbed;                                                  // with the velocity of its arrival
    ASSERT_NEAR(g.velocity[i].x() / -g.velocity[i].y(), 0.5, 1e-6);  // 0.5 m/s on drops of 1 m/s
  }
  EXPECT_GT(num_absorbed, 50) << "the sky still rains on the plate";
}

TEST(Weather, DriversSeeItsMeanOverTheTimeSinceTheTileAgedLast) {
  Scene scene = testing_support::plate_scene(64);
  scene.emitters[0].is_on = false;
  scene.weather = showers(10.0);
  Rule rule{.name = "wet", .driver = "rain", .rate = 0.01};
  rule.products[2] = 1.0;
  scene.rules = {rule};
  Simulation simulation(scene);
  constexpr int kIterations = 200 * 8;  // 8 passes of 10
  for (int i = 0; i < kIterations; ++i) simulation.step();
  // 0.01 * 1.7 * 80 = 1.36 at every texel, less what tiles lag: up to 7 iterations of at most 5 * 0.05 * 0.01.
  const SurfaceAtlas& surface = simulation.atlas().surface();
  for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    ASSERT_NEAR(simulation.atlas().amount(2, t) / double{kAmountOne}, 1.36, 7 * 5 * 0.05 * 0.01 + 2e-3);
  }
}

TEST(Weather, TilesThatSleepWakeWhenItChanges) {
  Scene scene = testing_support::plate_scene(64);
  scene.emitters[0].is_on = false;
  Weather late;
  late.rows = {{.time = 0, .values = {0}}, {.time = 4, .values = {1}}};
  late.is_given[kRain] = true;
  scene.weather = late;
  Rule rule{.name = "wet", .driver = "rain", .rate = 0.1};
  rule.products[2] = 1.0;
  scene.rules = {rule};
  Simulation simulation(scene);
  for (int i = 0; i < 80; ++i) simulation.step();  // asleep since the first epoch
  EXPECT_EQ(simulation.atlas().mass(2), 0);
  for (int i = 0; i < 88; ++i) simulation.step();
  const double area = static_cast<double>(simulation.atlas().surface().num_covered()) * SurfaceAtlas::kMedianWeight;
  EXPECT_NEAR(static_cast<double>(simulation.atlas().mass(2)) / (kAmountOne * area), 0.1 * 4.4, 0.05);
}

TEST(Weather, GoesOnFromASnapshotAndIsTheSameForAnyNumberOfThreads) {
  Scene scene = plate_in(showers(6.0));
  scene.weather.is_given[kWind] = true;
  for (WeatherRow& row : scene.weather.rows) row.values[kWind] = 0.3 + row.time;
  Rule rule = testing_support::rust_rule(0.5);
  rule.driver = "min(water, metal) * (1 + rain) / (1 + wind)";
  scene.rules = {rule};
  Simulation whole(scene);
  RunControl one;
  one.num_threads = 1;
  for (int i = 0; i < 150; ++i) whole.step(one);
  Simulation first(scene);
  for (int i = 0; i < 67; ++i) first.step();
  const std::vector<std::byte> middle = first.snapshot();
  Simulation second(scene);
  second.restore(middle);
  for (int i = 67; i < 150; ++i) second.step();
  EXPECT_TRUE(second.snapshot() == whole.snapshot());
  EXPECT_EQ(second.audit(), "");
}

TEST(Weather, AnEmitterFollowsOnlyWhatTheSceneTellsOf) {
  Scene scene = plate_in(showers());
  scene.emitters[0].follows = WeatherSignal::Wind;
  EXPECT_TRUE(has(error_of([&] { Simulation{scene}; }),
                  "the emitter 'rain' follows the wind, of which the scene's weather says nothing"));
  scene = plate_in(showers());
  scene.time_per_iteration = 0.0;
  EXPECT_TRUE(has(error_of([&] { Simulation{scene}; }), "the scene has weather, and its iterations take no time"));
}

}  // namespace
}  // namespace patinate::simulation
