// Parameter maps say what happened to a place, whatever texels the atlas has there.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "patinate/simulation/engine.h"

namespace patinate::simulation {
namespace {

constexpr double kFine = 0.7, kCoarse = 0.14;  ///< Sides of two charts in UV, each of 50 x 50 mm: 25 times the area.

void add_square(Mesh& mesh, double x, double u, double side) {
  const int first = static_cast<int>(mesh.positions.size());
  for (const auto& [a, b] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}) {
    mesh.positions.push_back(Vec3(x + 50.0 * a, 50.0 * b, 0.0));
    mesh.uvs.push_back(Vec2(u + side * a, 0.02 + side * b));
  }
  for (const Triangle t : {Triangle{first, first + 1, first + 2}, {first, first + 2, first + 3}}) {
    mesh.triangles.push_back(t);
    mesh.uv_triangles.push_back(t);
  }
}

/// Two level squares side by side, one of fine texels and one of coarse ones, in rain that stays where it falls.
Scene uneven_plate() {
  Scene scene;
  scene.materials = {"dirt"};
  scene.appearance.resize(1);
  scene.resolution = 256;
  SceneObject object;
  object.name = "plate";
  add_square(object.mesh, 0.0, 0.02, kFine);
  add_square(object.mesh, 50.0, 0.8, kCoarse);
  object.rotate_deg = Vec3(-90, 0, 0);
  scene.objects.push_back(object);
  Emitter rain;
  rain.name = "rain";
  rain.shape = EmitterShape::Rectangle;
  rain.position_mm = Vec3(50, 10, -25);
  rain.size_mm = {105, 55};
  rain.speed_mm_s = 3000;
  rain.gammatons = 4000;
  rain.carries[0] = 1.0;
  scene.emitters.push_back(rain);
  scene.behavior = {
      .bounce = 0.0, .floating = 0.0, .absorb = 1.0, .deceleration_bounce = 0.0, .deceleration_float = 0.0};
  scene.exchange = {.ratio = 1.0, .rates = {0.05}, .splat_texels = 1};
  return scene;
}

/// Mean over the fine and over the coarse chart, by area.
std::array<double, 2> means(const Simulation& simulation, const std::string& name) {
  const SurfaceAtlas& surface = simulation.atlas().surface();
  const ImageF values = simulation.parameter_map(name).values;
  std::array<double, 2> sum{}, area{};
  for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    const std::size_t chart = surface.triangle(t) < 2 ? 0 : 1;
    sum[chart] += static_cast<double>(values.at(surface.grid().x(t), surface.grid().y(t))) * surface.area_mm2(t);
    area[chart] += surface.area_mm2(t);
  }
  return {sum[0] / area[0], sum[1] / area[1]};
}

class ParameterMapsByWidth : public testing::TestWithParam<double> {};

TEST_P(ParameterMapsByWidth, AreTheSameOnFineAndOnCoarseTexels) {
  Scene scene = uneven_plate();
  scene.exchange.splat_mm = GetParam();
  Simulation simulation(scene, {.parameter_maps = {"hits", "last_hit", "residence"}});
  constexpr int kIterations = 200;
  for (int i = 0; i < kIterations; ++i) simulation.step();
  // Some 350,000 drops on either chart: counts differ by 0.2 % by chance, weights of the atlas are whole numbers of
  // some ten in the fine one. goals.md asks for 0.95 to 1.05.
  const auto hits = means(simulation, "hits");
  EXPECT_NEAR(hits[1] / hits[0], 1.0, 0.05);
  // 4,000 drops an iteration on 105 x 55 mm.
  EXPECT_NEAR(hits[0], kIterations * 4000.0 / (105.0 * 55.0), 0.05 * hits[0]);
  const auto residence = means(simulation, "residence");
  EXPECT_NEAR(residence[1] / residence[0], 1.0, 0.05);
  // Of a coarse texel only the iteration is known, which stands for 25 of a fine one's: by 2 of 200, 1 %, too early in
  // the mean.
  const auto last = means(simulation, "last_hit");
  EXPECT_NEAR(last[1] / last[0], 1.0, 0.05);
}

// Drops of one texel, and of one width in mm: a few coarse texels, hundreds of fine ones.
INSTANTIATE_TEST_SUITE_P(Widths, ParameterMapsByWidth, testing::Values(0.0, 2.0));

}  // namespace
}  // namespace patinate::simulation
