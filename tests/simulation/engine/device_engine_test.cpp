#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "patinate/simulation/engine.h"
#include "simulation/device/simulation_device.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using device::DeviceInfo;

/// Two plates in the rain that rust and dry; one is moved and grows, a rule changes on the way and looks at the
/// surface.
Scene plates_with_events(int resolution) {
  Scene scene = testing_support::plate_scene(resolution);
  scene.objects.push_back(scene.objects[0]);
  scene.objects[1].name = "other";
  scene.objects[1].translate_mm = Vec3(30, -15, 10);
  scene.emitters[0].gammatons = 2000;
  scene.rules.push_back(testing_support::rust_rule(0.5));
  scene.rules.push_back({.name = "dry", .driver = "water", .rate = 0.3, .reactants = {1.0}});
  RuleEvent other{.rule = "rust", .change = {}};
  other.change.driver = "pow(water, 0.5) * exposure";
  scene.events = {{.iteration = 40, .what = other},
                  {.iteration = 80, .what = MoveEvent{.target = "other", .position_mm = Vec3(-20, -20, 5)}},
                  {.iteration = 120, .what = ScaleEvent{.object = "other", .scale = 1.5}}};
  return scene;
}

class SimulationOnDevices : public testing::TestWithParam<int> {};

// What is saved on a device goes on without one, and the other way round.
TEST_P(SimulationOnDevices, GivesTheCpusBytesThroughEventsAndSnapshots) {
  const std::vector<DeviceInfo> all = device::list_devices();
  if (all.empty()) GTEST_SKIP() << "there is no OpenCL device (Debian: pocl-opencl-icd)";
  constexpr int kIterations = 200, kSaved = 100;
  Simulation here(plates_with_events(GetParam()));
  for (int i = 0; i < kIterations; ++i) here.step();
  const std::vector<std::byte> expected = here.snapshot();
  const Composer& composed = here.compose();
  for (const DeviceInfo& info : all) {
    SimulationOptions options;
    options.device = std::make_shared<const SimulationDevice>(
        device::Device(info), [](const device::DeviceError& problem) { ADD_FAILURE() << problem.what(); });
    Simulation there(plates_with_events(GetParam()), options);
    std::vector<std::byte> saved;
    for (int i = 0; i < kIterations; ++i) {
      if (i == kSaved) saved = there.snapshot();
      there.step();
    }
    EXPECT_TRUE(there.snapshot() == expected) << info.name;
    EXPECT_EQ(there.atlas().hash(), here.atlas().hash());
    const Composer& composed_there = there.compose();
    EXPECT_TRUE(std::equal(composed.codes().begin(), composed.codes().end(), composed_there.codes().begin()));
    EXPECT_TRUE(std::equal(composed.normals().begin(), composed.normals().end(), composed_there.normals().begin()));
    Simulation without(plates_with_events(GetParam()));
    without.restore(saved);
    for (int i = kSaved; i < kIterations; ++i) without.step();
    EXPECT_TRUE(without.snapshot() == expected) << info.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Resolutions, SimulationOnDevices, testing::Values(256, 512));

}  // namespace
}  // namespace patinate::simulation
