#include "simulation/aged_frames.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace patinate {
namespace {

/// An iron plate in the rain; frames after 0, 8, 16 and 20 iterations.
SceneFile plate() {
  SceneFile file;
  Scene& scene = file.scene;
  scene.materials = {"water", "metal", "rust"};
  scene.looks.resize(3);
  scene.looks[2].color.color = Vec3(0.2, 0.06, 0.02);
  scene.resolution = 64;
  SceneObject object;
  object.name = "plate";
  object.mesh = testing_support::unit_plane(100.0);
  object.preset.amounts[1] = 1.0;
  object.rotate_deg = Vec3(-60, 0, 0);
  scene.objects.push_back(object);
  Emitter rain;
  rain.name = "rain";
  rain.shape = EmitterShape::Sky;
  rain.gammatons = 200;
  rain.carries[0] = 0.8;
  scene.emitters.push_back(rain);
  scene.exchange.rates[0] = 0.4;
  Rule rust{.name = "rust", .driver = "min(water, metal)", .alpha = 5.0};
  rust.makes[2] = 1.0;
  scene.rules.push_back(rust);
  scene.time_per_iteration = 0.05;
  file.iterations = 20;
  file.history_every = 8;
  file.controls = {"hits"};
  return file;
}

std::vector<float> values_of(const ImageF& image) { return {image.values().begin(), image.values().end()}; }

TEST(AgedFrames, ShowWhatTheSimulationShowsAtEveryFrame) {
  const SceneFile file = plate();
  AgedFrames aged(file, {});
  EXPECT_EQ(aged.times(), (std::vector<double>{0.0, 0.4, 0.8, 1.0}));
  const std::vector<ImageF> frames = aged.compose(file.scene.looks);
  Simulation simulation(file.scene, {.parameter_maps = {"hits"}});
  std::size_t k = 0;
  for (const std::int64_t end : {0, 8, 16, 20}) {
    while (simulation.iteration() < end) simulation.step();
    EXPECT_EQ(values_of(frames[k]), values_of(simulation.compose().color_linear())) << "frame " << k;
    ++k;
  }
  EXPECT_NE(values_of(frames.front()), values_of(frames.back()));
  EXPECT_EQ(values_of(aged.controls().at(0).values), values_of(parameter_control(simulation, "hits").values));
}

TEST(AgedFrames, AnotherLookIsThatOfASimulationWithItAndTheFirstOneComesBack) {
  SceneFile file = plate();
  AgedFrames aged(file, {});
  const std::vector<ImageF> before = aged.compose(file.scene.looks);
  std::vector<MaterialLook> other = file.scene.looks;
  other[2].strength = 0.3;
  other[2].variation = 0.5;
  other[0].color.color = Vec3(0.0, 0.0, 0.5);
  SceneFile changed = file;
  changed.scene.looks = other;
  const std::vector<ImageF> expected = AgedFrames(changed, {}).compose(other), got = aged.compose(other), after = aged.compose(file.scene.looks);
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(values_of(got[k]), values_of(expected[k]));
    EXPECT_EQ(values_of(after[k]), values_of(before[k]));
  }
  EXPECT_NE(values_of(got.back()), values_of(before.back()));
}

}  // namespace
}  // namespace patinate
