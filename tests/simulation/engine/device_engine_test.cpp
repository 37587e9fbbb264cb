#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "patinate/simulation/engine.h"
#include "simulation/device/simulation_device.h"
#include "simulation/engine/iteration_check.h"
#include "tests/support/lost_device.h"
#include "tests/support/object_scenes.h"
#include "tests/support/on_devices.h"
#include "tests/support/plate_scene.h"
#include "tests/support/test_data.h"

namespace patinate::simulation {
namespace {

using device::DeviceInfo;

/// Two plates in the rain that rust and dry; one is moved and grows, a rule changes on the way and looks at the
/// surface, and somebody paints.
Scene plates_with_events(int resolution) {
  Scene scene = testing_support::plate_scene(resolution);
  scene.objects.push_back(scene.objects[0]);
  scene.objects[1].name = "other";
  scene.objects[1].translate_mm = Vec3(30, -15, 10);
  scene.emitters[0].gammatons = 2000;
  Emitter brush = scene.emitters[0];
  brush.name = "brush";
  brush.shape = EmitterShape::Disk;
  brush.size_mm = {8, 8};
  brush.gammatons = 160;
  brush.is_on = false;
  scene.emitters.push_back(brush);
  scene.rules.push_back(testing_support::rust_rule(0.5));
  scene.rules.push_back({.name = "dry", .driver = "water", .rate = 0.3, .reactants = {1.0}});
  RuleEvent other{.rule = "rust", .change = {}};
  other.change.driver = "pow(water, 0.5) * slope";
  const PaintEvent stroke{.emitter = "brush", .stops = {{Vec3(0, 0, 60), 6}, {Vec3(5, 3, 60), 6}}};
  scene.events = {{.iteration = 20, .what = stroke},
                  {.iteration = 40, .what = other},
                  {.iteration = 80, .what = MoveEvent{.target = "other", .position_mm = Vec3(-20, -20, 5)}},
                  {.iteration = 120, .what = ScaleEvent{.object = "other", .scale = 1.5}}};
  return scene;
}

struct Case {
  const char* name;
  Scene (*scene)(int resolution);
  int resolution;
};

std::string name_of(const testing::TestParamInfo<Case>& info) {
  return std::string(info.param.name) + std::to_string(info.param.resolution);
}

/// All that a run remembers is in its snapshot; maps too where they are asked for.
const std::vector<std::string> kMaps{"hits", "last_hit", "residence", "water.deposited"};

Simulation without_device(const Scene& scene) { return Simulation(scene, {.parameter_maps = kMaps}); }

Simulation on_device(const Scene& scene, const device::Device& device, int& num_failures) {
  SimulationOptions options{.parameter_maps = kMaps};
  options.device =
      std::make_shared<const SimulationDevice>(device, [&](const device::DeviceError&) { ++num_failures; });
  return Simulation(scene, options);
}

void expect_same_textures(const Composer& a, const Composer& b) {
  EXPECT_TRUE(std::equal(a.codes().begin(), a.codes().end(), b.codes().begin()));
  EXPECT_TRUE(std::equal(a.normals().begin(), a.normals().end(), b.normals().begin()));
}

class SimulationOnDevices : public testing_support::OnDevices<testing::TestWithParam<Case>> {};

// A run that is saved on a device goes on without one, and the other way round.
TEST_P(SimulationOnDevices, GivesTheCpusBytesThroughEventsAndSnapshots) {
  constexpr int kIterations = 200, kSaved = 100;
  if (GetParam().resolution > 256) PATINATE_NIGHTLY_ONLY();
  const Scene scene = GetParam().scene(GetParam().resolution);
  Simulation here = without_device(scene);
  std::vector<std::byte> saved_here;
  for (int i = 0; i < kIterations; ++i) {
    if (i == kSaved) saved_here = here.snapshot();
    here.step();
  }
  const std::vector<std::byte> expected = here.snapshot();
  EXPECT_TRUE(here.ledger().balances());
  const Composer& composed = here.compose();
  for (const DeviceInfo& info : all) {
    int num_failures = 0;
    Simulation there = on_device(scene, device::Device(info), num_failures);
    std::vector<std::byte> saved_there;
    for (int i = 0; i < kIterations; ++i) {
      if (i == kSaved) saved_there = there.snapshot();
      there.step();
    }
    EXPECT_TRUE(there.snapshot() == expected) << info.name;
    EXPECT_TRUE(saved_there == saved_here) << info.name;
    EXPECT_EQ(there.atlas().hash(), here.atlas().hash());
    expect_same_textures(composed, there.compose());
    Simulation without = without_device(scene), later = on_device(scene, device::Device(info), num_failures);
    without.restore(saved_there);
    later.restore(saved_here);
    for (int i = kSaved; i < kIterations; ++i) {
      without.step();
      later.step();
    }
    EXPECT_TRUE(without.snapshot() == expected) << info.name;
    EXPECT_TRUE(later.snapshot() == expected) << info.name;
    EXPECT_EQ(num_failures, 0) << info.name;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, SimulationOnDevices,
    testing::Values(Case{"Plates", &plates_with_events, 256}, Case{"Plates", &plates_with_events, 512},
                    Case{"Wall", &testing_support::wall_scene, 256}, Case{"Wall", &testing_support::wall_scene, 512},
                    Case{"Urn", &testing_support::urn_scene, 256}, Case{"Urn", &testing_support::urn_scene, 512}),
    name_of);

class IterationsOnDevices : public testing_support::OnDevices<> {};

TEST_F(IterationsOnDevices, PassTheirOwnCheck) {
  for (const DeviceInfo& info : all) {
    const device::CheckResult check = check_iterations(device::Device(info));
    EXPECT_TRUE(check.is_passed()) << info.name << ": " << check.num_different << " of " << check.num_items;
  }
}

/// All rain falls on a small plate with fine texels, where splats have many times the parts that they have on the texel
/// of median size, by which a device first takes room.
Scene fine_plate_in_the_rain() {
  Scene scene = testing_support::plate_scene(512);
  scene.objects.push_back(scene.objects[0]);
  scene.objects[0].scale = 4.0;
  scene.objects[0].texels_per_mm = 1.0;
  scene.objects[1].name = "fine";
  scene.objects[1].scale = 0.25;
  scene.objects[1].texels_per_mm = 4.0;
  scene.objects[1].translate_mm = Vec3(0, 0, 30);
  Emitter& rain = scene.emitters[0];
  rain.shape = EmitterShape::Disk;
  rain.position_mm = Vec3(0, 0, 60);
  rain.direction = Vec3(0, 0, -1);
  rain.speed_mm_s = 5000.0;
  rain.size_mm = {8, 8};
  rain.gammatons = 600;
  scene.behavior = {.bounce = 0.0, .floating = 0.9, .absorb = 0.1};
  scene.exchange.splat_mm = 6.0;
  return scene;
}

// A device finds that out when it is done, and does all of it again.
TEST_F(IterationsOnDevices, AreDoneAgainWhereThereWasTooLittleRoom) {
  constexpr int kIterations = 12;
  const Scene scene = fine_plate_in_the_rain();
  Simulation here = without_device(scene);
  for (int i = 0; i < kIterations; ++i) here.step();
  const Composer& composed = here.compose();
  for (const DeviceInfo& info : all) {
    int num_failures = 0;
    const device::Device device(info);
    Simulation there = on_device(scene, device, num_failures);
    for (int i = 0; i < kIterations; ++i) {
      there.step();
      (void)there.compose();
    }
    EXPECT_TRUE(there.snapshot() == here.snapshot()) << info.name;
    expect_same_textures(composed, there.compose());
    EXPECT_EQ(num_failures, 0) << info.name;
    EXPECT_GT(device.times().kernels.at("trace_drops").num_launches, kIterations) << info.name;
  }
}

// Other looks for the same amounts, after an odd and an even number of pictures; and an older picture that is asked for
// late shows what was composed.
TEST_F(IterationsOnDevices, ShowOtherLooksAsTheCpuDoes) {
  Scene scene = testing_support::urn_scene(256);
  scene.appearance[2].height_mm = 0.5;
  for (const DeviceInfo& info : all) {
    int num_failures = 0;
    Simulation here = without_device(scene), there = on_device(scene, device::Device(info), num_failures);
    for (int i = 0; i < 7; ++i) {
      here.step();
      there.step();
      (void)here.compose();
      (void)there.compose();
      here.step();
      there.step();
      EXPECT_TRUE(std::equal(here.composed_tiles().begin(), here.composed_tiles().end(), there.composed_tiles().begin(),
                             there.composed_tiles().end()))
          << info.name << " " << i;
      if (i % 3 != 0) continue;
      scene.appearance[2].height_mm += 0.4;
      scene.appearance[2].strength = 1.0 + i;
      here.set_appearance(scene.appearance);
      there.set_appearance(scene.appearance);
      expect_same_textures(here.compose(), there.compose());
    }
    EXPECT_EQ(num_failures, 0) << info.name;
  }
}

// A driver that works with more than 64 values at a texel stays on the CPU, and with it all iterations.
TEST_F(IterationsOnDevices, StayOnTheCpuWhereADriverIsTooLong) {
  Scene scene = plates_with_events(256);
  std::string sum = "water";
  for (int i = 0; i < 70; ++i) sum = "(water * " + std::to_string(i + 2) + ".5 + " + sum + ")";
  scene.rules[0].driver = "min(1, " + sum + ")";
  Simulation here = without_device(scene);
  int num_failures = 0;
  const device::Device device(all[0]);
  Simulation there = on_device(scene, device, num_failures);
  for (int i = 0; i < 10; ++i) {
    here.step();
    there.step();
  }
  EXPECT_TRUE(there.snapshot() == here.snapshot());
  EXPECT_EQ(num_failures, 0);
}

// Before it does anything, when gammatons have been traced and wait for their response, some iterations later, and when
// what was composed is asked for.
TEST(SimulationOnLostDevices, GoesOnWithTheSameBytes) {
  const std::vector<DeviceInfo> all = device::list_devices();
  if (all.empty()) GTEST_SKIP() << "there is no OpenCL device (Debian: pocl-opencl-icd)";
  const Scene scene = plates_with_events(256);
  constexpr int kIterations = 20;
  Simulation here = without_device(scene);
  for (int i = 0; i < kIterations; ++i) here.step();
  const device::Device sound(all[0]);
  int none = 0;
  Simulation without_loss = on_device(scene, sound, none);
  for (int i = 0; i < kIterations; ++i) without_loss.step();
  expect_same_textures(here.compose(), without_loss.compose());
  EXPECT_TRUE(without_loss.snapshot() == here.snapshot());
  int num_all = 0;
  for (const auto& [name, kernel] : sound.times().kernels) num_all += static_cast<int>(kernel.num_launches);
  for (const int num_launches : {0, 1, 2, 9, num_all / 2, num_all - 6, num_all - 5, num_all - 4, num_all - 1}) {
    int num_failures = 0;
    const device::Device lost(all[0], testing_support::driver_with_launches(num_launches));
    Simulation there = on_device(scene, lost, num_failures);
    for (int i = 0; i < kIterations; ++i) there.step();
    expect_same_textures(here.compose(), there.compose());
    EXPECT_TRUE(there.snapshot() == here.snapshot()) << num_launches;
    EXPECT_EQ(num_failures, 1) << num_launches;
  }
}

}  // namespace
}  // namespace patinate::simulation
