#include "simulation/rules/device_rules.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "libcommon/core/random.h"
#include "simulation/device/check_scene.h"
#include "simulation/device/simulation_device.h"
#include "simulation/rules/rules.h"
#include "tests/simulation/transport/transport_scene.h"
#include "tests/support/lost_device.h"
#include "tests/support/on_devices.h"

namespace patinate::simulation {
namespace {

using device::Device;
using device::DeviceInfo;
using testing_support::TransportScene;

const std::vector<std::string> kNames{"water", "metal", "rust"};

class RulesOnDevices : public testing_support::OnDevices<> {};

/// Amounts from none to the most that there can be, some pages left as they are.
void set_any_amounts(TransportScene& scene, std::uint64_t seed) {
  for (const TexelIndex t : scene.covered) {
    RandomStream random(seed, t);
    if (TileGrid::page_of(t) % 3 == 2) continue;
    for (int m = 0; m < 3; ++m) {
      const std::uint32_t most = random.below(4) == 0 ? kMaxAmount + 1 : 3000;
      scene.atlas->writable_tile(m, TileGrid::tile_of(t))[t % 64] = static_cast<std::uint16_t>(random.below(most));
    }
  }
}

std::vector<Rule> any_rules() {
  std::vector<Rule> rules(3);
  rules[0] = {.name = "rust", .driver = "min(water, metal)", .rate = 0.4, .products = {0, 0, 1.0}, .reactants = {0, 1}};
  rules[1] = {.name = "dry", .driver = "water + rain", .rate = 0.5, .reactants = {1.0}};
  rules[2] = {.name = "grow", .driver = "pow(rust, 0.5) * (1 - rust / 2)", .rate = 0.1, .products = {0.2, 0, 1.0}};
  return rules;
}

void expect_equal(const RuleReport& a, const RuleReport& b, const std::string& where) {
  EXPECT_TRUE(std::equal(a.dirty_tiles.begin(), a.dirty_tiles.end(), b.dirty_tiles.begin(), b.dirty_tiles.end()))
      << where;
  EXPECT_EQ(a.made, b.made) << where;
  EXPECT_EQ(a.used, b.used) << where;
}

TEST_F(RulesOnDevices, PassTheirOwnCheck) {
  for (const DeviceInfo& info : all) {
    const device::CheckResult check = check_rules(Device(info));
    EXPECT_TRUE(check.is_passed()) << info.name << ": " << check.num_different << " of " << check.num_items;
  }
}

// Texels of unequal size, pages that are not there yet, tiles that fall asleep and are woken, other rules on the way,
// weather that changes: amounts, what was made and used, which tiles changed and which sleep are the CPU's.
TEST_F(RulesOnDevices, GiveTheCpusBytes) {
  constexpr int kIterations = 64;
  for (const DeviceInfo& info : all) {
    TransportScene here = testing_support::squeezed_plane(256), there = testing_support::squeezed_plane(256);
    set_any_amounts(here, 3);
    set_any_amounts(there, 3);
    RuleEngine cpu(any_rules(), kNames, *here.surface, 0.1, 5), gpu(any_rules(), kNames, *there.surface, 0.1, 5);
    gpu.use(std::make_shared<const SimulationDevice>(
        Device(info), [&](const device::DeviceError& problem) { ADD_FAILURE() << problem.what(); }));
    Weather weather;
    weather.rows = {{.time = 0.0}, {.time = 4.0, .values = {1.5}}};
    weather.is_given[0] = true;
    cpu.set_weather(weather);
    gpu.set_weather(weather);
    for (int i = 0; i < kIterations; ++i) {
      if (i == kIterations / 2) {
        std::vector<Rule> others = any_rules();
        others.erase(others.begin() + 1);
        others[0].driver = "metal * clamp(water, 0.1, 0.7)";
        cpu.set_rules(others, kNames);
        gpu.set_rules(others, kNames);
      }
      expect_equal(cpu.step(i, *here.atlas), gpu.step(i, *there.atlas), info.name + ": " + std::to_string(i));
      ASSERT_EQ(cpu.num_awake(), gpu.num_awake()) << info.name << ": " << i;
      ASSERT_EQ(here.atlas->hash(), there.atlas->hash()) << info.name << ": " << i;
      EXPECT_EQ(here.atlas->memory(), there.atlas->memory());
    }
  }
}

/// An expression of any form, at most `depth` deep; huge and tiny numbers, quotients by 0 and powers of what is
/// negative among them.
std::string any_driver(RandomStream& random, int depth) {
  static const std::vector<std::string> leaves{"water", "metal", "rust",  "age",  "rain",
                                               "0",     "-3",    "1e-30", "1e20", "0.5"};
  if (depth == 0) return leaves[random.below(static_cast<std::uint32_t>(leaves.size()))];
  const auto part = [&] { return any_driver(random, depth - 1); };
  switch (random.below(11)) {
    case 0:
      return "(" + part() + " + " + part() + ")";
    case 1:
      return "(" + part() + " - " + part() + ")";
    case 2:
      return "(" + part() + " * " + part() + ")";
    case 3:
      return "(" + part() + " / " + part() + ")";
    case 4:
      return "-(" + part() + ")";
    case 5:
      return "!(" + part() + ")";
    case 6:
      return "min(" + part() + ", " + part() + ", " + part() + ")";
    case 7:
      return "max(" + part() + ", " + part() + ")";
    case 8:
      return "pow(" + part() + ", " + part() + ")";
    case 9:
      return "clamp(" + part() + ", " + part() + ", " + part() + ")";
    default:
      return "smoothstep(" + part() + ", " + part() + ", abs(" + part() + "))";
  }
}

TEST_F(RulesOnDevices, GiveTheCpusBytesForAnyDriver) {
  constexpr std::uint64_t kSets = 12;
  for (std::uint64_t set = 0; set < kSets; ++set) {
    RandomStream random(8, set);
    std::vector<Rule> rules = any_rules();
    for (Rule& rule : rules) {
      rule.driver = any_driver(random, 1 + static_cast<int>(random.below(4)));
      rule.rate = random.uniform();
    }
    TransportScene here = testing_support::squeezed_plane(128), there = testing_support::squeezed_plane(128);
    set_any_amounts(here, set);
    set_any_amounts(there, set);
    RuleEngine cpu(rules, kNames, *here.surface, 0.1, 5), gpu(rules, kNames, *there.surface, 0.1, 5);
    gpu.use(std::make_shared<const SimulationDevice>(
        Device(all[0]), [&](const device::DeviceError& problem) { ADD_FAILURE() << problem.what(); }));
    const std::string drivers = rules[0].driver + "; " + rules[1].driver + "; " + rules[2].driver;
    for (int i = 0; i < 16; ++i) expect_equal(cpu.step(i, *here.atlas), gpu.step(i, *there.atlas), drivers);
    EXPECT_EQ(here.atlas->hash(), there.atlas->hash()) << drivers;
  }
}

// A device has 64 values for a texel: a driver that needs more is the CPU's, without a word.
TEST_F(RulesOnDevices, LeaveDriversThatAreTooLongToTheCpu) {
  std::string deep = "water";
  for (int i = 0; i < 70; ++i) deep = "(metal + " + deep + ")";
  std::vector<Rule> rules(1);
  rules[0] = {.name = "deep", .driver = deep, .rate = 0.001, .reactants = {1.0}};
  TransportScene here = testing_support::squeezed_plane(128), there = testing_support::squeezed_plane(128);
  set_any_amounts(here, 4);
  set_any_amounts(there, 4);
  RuleEngine cpu(rules, kNames, *here.surface, 0.1, 5), gpu(rules, kNames, *there.surface, 0.1, 5);
  gpu.use(std::make_shared<const SimulationDevice>(
      Device(all[0]), [&](const device::DeviceError& problem) { ADD_FAILURE() << problem.what(); }));
  for (int i = 0; i < 8; ++i) expect_equal(cpu.step(i, *here.atlas), gpu.step(i, *there.atlas), std::to_string(i));
  EXPECT_EQ(here.atlas->hash(), there.atlas->hash());
}

// More tiles are due than a device is given at once: lost before the first batch, between two, and in a later step.
TEST_F(RulesOnDevices, ThatAreLostLeaveTheRestToTheCpu) {
  constexpr int kResolution = 1600;  // 40,000 tiles: 5000 are due at once, 4096 of them in a batch.
  for (const int num_launches : {0, 1, 3}) {
    TransportScene here = testing_support::squeezed_plane(kResolution),
                   there = testing_support::squeezed_plane(kResolution);
    RuleEngine cpu(any_rules(), kNames, *here.surface, 0.1, 5), gpu(any_rules(), kNames, *there.surface, 0.1, 5);
    int num_failures = 0;
    gpu.use(
        std::make_shared<const SimulationDevice>(Device(all[0], testing_support::driver_with_launches(num_launches)),
                                                 [&](const device::DeviceError&) { ++num_failures; }));
    for (int i = 0; i < 3; ++i) expect_equal(cpu.step(i, *here.atlas), gpu.step(i, *there.atlas), std::to_string(i));
    EXPECT_EQ(here.atlas->hash(), there.atlas->hash());
    EXPECT_EQ(num_failures, 1);
  }
}

}  // namespace
}  // namespace patinate::simulation
