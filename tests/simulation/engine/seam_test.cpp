// Seams: what lies on both sides of one differs no more than neighbors inside a chart do, under rain that falls on all
// places alike.
#include <gtest/gtest.h>

#include <cmath>

#include "patinate/simulation/engine.h"
#include "tests/support/meshes.h"

namespace patinate::simulation {
namespace {

constexpr int kCharts = 12;  ///< A side: 144 charts, each turned by an angle of its own.
constexpr double kGoal = 1.05;

/// A level quilt under parallel rain that stays where it falls.
Scene quilt(int splat_texels) {
  Scene scene;
  scene.materials = {"dirt"};
  scene.appearance.resize(1);
  scene.appearance[0].color.color = Vec3(0.05, 0.04, 0.03);
  scene.appearance[0].height_mm = 0.1;
  scene.resolution = 512;
  SceneObject object;
  object.name = "quilt";
  object.mesh = testing_support::quilt_plane(100.0, kCharts);
  object.rotate_deg = Vec3(-90, 0, 0);
  scene.objects.push_back(object);
  Emitter rain;
  rain.name = "rain";
  rain.shape = EmitterShape::Rectangle;
  rain.position_mm = Vec3(50, 10, -50);
  rain.size_mm = {105, 105};
  rain.speed_mm_s = 3000;
  rain.gammatons = 50000;
  rain.carries[0] = 1.0;
  scene.emitters.push_back(rain);
  scene.behavior = {
      .bounce = 0.0, .floating = 0.0, .absorb = 1.0, .deceleration_bounce = 0.0, .deceleration_float = 0.0};
  scene.exchange = {.ratio = 1.0, .rates = {0.05}, .splat_texels = splat_texels, .deposit = false};
  return scene;
}

int chart_of(const TileGrid& grid, TexelIndex t) {
  return grid.y(t) * kCharts / grid.height * kCharts + grid.x(t) * kCharts / grid.width;
}

/// Root of the mean square of what differs between neighbors across seams, over that inside charts.
template <class Value>
double seam_ratio(const SurfaceAtlas& surface, Value&& value) {
  const TileGrid& grid = surface.grid();
  double inside = 0.0, across = 0.0, num_inside = 0.0, num_across = 0.0;
  for (TexelIndex t = 0; t < grid.num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    for (const TexelIndex n : surface.neighbors(t)) {
      if (n == kNoTexel) continue;
      const double d = value(t) - value(n);
      const bool is_inside = chart_of(grid, t) == chart_of(grid, n);
      (is_inside ? inside : across) += d * d;
      (is_inside ? num_inside : num_across) += 1.0;
    }
  }
  EXPECT_GT(num_across, 10'000.0);
  return std::sqrt(across / num_across) / std::sqrt(inside / num_inside);
}

/// Runs it and says how much larger differences are across seams than inside charts: of amounts, colors and heights.
void check_seams(int splat_texels) {
  Simulation simulation(quilt(splat_texels));
  for (int i = 0; i < (splat_texels == 1 ? 24 : 12); ++i) simulation.step();
  const MaterialAtlas& atlas = simulation.atlas();
  const Composer& composer = simulation.compose();
  const ImageU8 colors = composer.color_srgb8();
  const ImageF heights = composer.height_mm();
  const TileGrid& grid = atlas.surface().grid();
  const double amount =
      seam_ratio(atlas.surface(), [&](TexelIndex t) { return static_cast<double>(atlas.amount(0, t)); });
  const double color = seam_ratio(
      atlas.surface(), [&](TexelIndex t) { return static_cast<double>(colors.at(grid.x(t), grid.y(t), 1)); });
  const double height =
      seam_ratio(atlas.surface(), [&](TexelIndex t) { return static_cast<double>(heights.at(grid.x(t), grid.y(t))); });
  // Texels at a seam are from half to one and a half times as large, and small ones have rarer, heavier hits: sqrt(ln
  // 3) = 1.048 is what counting alone makes of that; wide splats even it out.
  EXPECT_LE(amount, kGoal);
  EXPECT_LE(color, kGoal);
  EXPECT_LE(height, kGoal);
  EXPECT_GT(amount, 0.95) << "a seam that is smoother than its surroundings shows as well";
  testing::Test::RecordProperty("amount", std::to_string(amount));
  testing::Test::RecordProperty("color", std::to_string(color));
  testing::Test::RecordProperty("height", std::to_string(height));
}

TEST(Seams, DifferNoMoreThanInsidesUnderSplatsOfOneTexel) { check_seams(1); }
TEST(Seams, DifferNoMoreThanInsidesUnderSplatsOfThreeTexels) { check_seams(3); }
TEST(Seams, DifferNoMoreThanInsidesUnderSplatsOfFiveTexels) { check_seams(5); }

TEST(Seams, TexelsAreHitAsOftenAsTheirWeightsSay) {
  SimulationOptions options;
  options.parameter_maps = {"hits"};
  Simulation simulation(quilt(1), options);
  for (int i = 0; i < 24; ++i) simulation.step();
  const SurfaceAtlas& surface = simulation.atlas().surface();
  const TileGrid& grid = surface.grid();
  const ImageF hits = simulation.parameter_map("hits").values;
  double sum = 0.0, weights = 0.0;
  for (TexelIndex t = 0; t < grid.num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    sum += static_cast<double>(hits.at(grid.x(t), grid.y(t))) * surface.area_mm2(t);
    weights += surface.weight(t);
  }
  // Poisson: (h - m)^2 / m is 1 in the mean, with a variance of 2 + 1 / m.
  double chi_square = 0.0, variance = 0.0;
  for (const TexelIndex t : surface.border()) {
    const double expected = sum * surface.weight(t) / weights;
    const double h = static_cast<double>(hits.at(grid.x(t), grid.y(t))) * surface.area_mm2(t);
    chi_square += (h - expected) * (h - expected) / expected - 1.0;
    variance += 2.0 + 1.0 / expected;
  }
  EXPECT_GT(surface.border().size(), 10'000u);
  EXPECT_LT(std::abs(chi_square), 4.0 * std::sqrt(variance));
}

}  // namespace
}  // namespace patinate::simulation
