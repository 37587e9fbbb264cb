#include "simulation/job/aged_frames.h"

#include <gtest/gtest.h>

#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

/// An iron plate in the rain; frames after 0, 8, 16 and 20 iterations.
SceneFile plate() {
  SceneFile file;
  file.scene = testing_support::plate_scene(64);
  file.scene.rules.push_back(testing_support::rust_rule(5.0));
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
  const std::vector<ImageF> frames = aged.compose(file.scene.appearance);
  Simulation simulation(file.scene, {.parameter_maps = {"hits"}});
  std::size_t k = 0;
  for (const std::int64_t end : {0, 8, 16, 20}) {
    while (simulation.iteration() < end) simulation.step();
    EXPECT_EQ(values_of(frames[k]), values_of(simulation.compose().color_linear())) << "frame " << k;
    ++k;
  }
  EXPECT_NE(values_of(frames.front()), values_of(frames.back()));
  EXPECT_EQ(values_of(aged.controls().at(0).values),
            values_of(parameter_control(simulation, "hits", TimeUnit::Days).values));
}

TEST(AgedFrames, AnotherLookIsThatOfASimulationWithItAndTheFirstOneComesBack) {
  SceneFile file = plate();
  AgedFrames aged(file, {});
  const std::vector<ImageF> before = aged.compose(file.scene.appearance);
  std::vector<MaterialAppearance> other = file.scene.appearance;
  other[2].strength = 0.3;
  other[2].variation = 0.5;
  other[0].color.color = Vec3(0.0, 0.0, 0.5);
  SceneFile changed = file;
  changed.scene.appearance = other;
  const std::vector<ImageF> expected = AgedFrames(changed, {}).compose(other), got = aged.compose(other),
                            after = aged.compose(file.scene.appearance);
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(values_of(got[k]), values_of(expected[k]));
    EXPECT_EQ(values_of(after[k]), values_of(before[k]));
  }
  EXPECT_NE(values_of(got.back()), values_of(before.back()));
}

}  // namespace
}  // namespace patinate::simulation
