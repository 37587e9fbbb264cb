// What a device is given of meshes, controls and histories that nobody would make by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "libcommon/core/random.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/history/memory_history.h"
#include "tests/support/errors.h"
#include "tests/support/meshes.h"
#include "tests/support/on_devices.h"
#include "transfer/synthesis/search_device.h"

namespace patinate::transfer {
namespace {

using device::Device;
using device::DeviceInfo;

constexpr int kAnySource = 48, kAnySize = 64;

/// Colors of few values, so that costs tie, one of them everywhere in some.
std::shared_ptr<const History> any_history(RandomStream& random) {
  MemoryHistoryImages images{.name = "any", .frames = {}};
  const int num_frames = 1 + static_cast<int>(random.below(3)), num_values = 1 + static_cast<int>(random.below(4));
  for (int f = 0; f < num_frames; ++f) {
    ImageF color(kAnySource, kAnySource, 3);
    for (float& c : color.values())
      c = static_cast<float>(random.below(static_cast<std::uint32_t>(num_values))) / static_cast<float>(num_values);
    images.frames.push_back({.time = static_cast<double>(f), .color = std::move(color)});
  }
  ImageF control(kAnySource, kAnySource);
  for (float& c : control.values()) c = static_cast<float>(random.uniform());
  images.controls.push_back(
      {.facts = {.name = "x", .low = 0.0, .high = 1.0, .unit = ""}, .values = std::move(control)});
  return std::make_shared<const MemoryHistory>(std::move(images));
}

/// Charts of several densities, some of whose triangles have no area: a corner twice, three on a line, or none in the
/// atlas; some are as small or as large as numbers get, and some lie over one another.
Mesh any_mesh(RandomStream& random) {
  Mesh mesh = testing_support::patchwork_plane(kAnySize, 1 + static_cast<int>(random.below(5)));
  const auto any_corner = [&] { return random.below(3); };
  for (Triangle& triangle : mesh.triangles) {
    if (random.below(9) == 0) triangle[any_corner()] = triangle[any_corner()];
  }
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    switch (random.below(24)) {
      case 0:
        mesh.positions[i] = mesh.positions[random.below(static_cast<std::uint32_t>(mesh.positions.size()))];
        break;
      case 1:
        mesh.positions[i] *= 1e-30;
        break;
      case 2:
        mesh.positions[i] += 1e6 * Vec3(random.uniform(), random.uniform(), random.uniform());
        break;
      case 3:
        mesh.uvs[i] = mesh.uvs[random.below(static_cast<std::uint32_t>(mesh.uvs.size()))];
        break;
      default:
        break;
    }
  }
  return mesh;
}

ImageF any_control(RandomStream& random) {
  ImageF values(kAnySize, kAnySize);
  const std::uint32_t kind = random.below(4);
  for (float& v : values.values()) {
    v = kind == 0   ? 0.5f
        : kind == 1 ? static_cast<float>(random.below(3)) * 0.5f
        : kind == 2 ? std::numeric_limits<float>::denorm_min() * static_cast<float>(random.below(9))
                    : static_cast<float>(random.uniform());
  }
  return values;
}

TransferInput any_input(RandomStream& random) {
  TransferInput input{.history = any_history(random),
                      .map = std::make_shared<const TexelMap>(any_mesh(random), kAnySize, kAnySize),
                      .texel_size_mm = random.below(4) == 0 ? 0.3 : 1.0,
                      .controls = {}};
  input.controls.push_back({"x", "any", any_control(random), {}, 1.0, ControlMapping::Rank});
  if (random.below(2) == 0) input.frames = std::make_shared<const FlowFrames>(uv_frames(*input.map));
  return input;
}

class SearchOfAnything : public testing_support::OnDevices<> {};

// What the CPU refuses, a device is not asked for; all else gives the same coordinates there, and none fails.
TEST_F(SearchOfAnything, GivesTheCpusCoordinatesOrIsRefused) {
  constexpr int kRounds = 24;
  int num_transferred = 0;
  for (int round = 0; round < kRounds; ++round) {
    RandomStream random(47, static_cast<std::uint64_t>(round));
    TransferInput input = any_input(random);
    TransferOptions options;
    options.neighborhood_radius_px = static_cast<int>(random.below(4)) + 1;
    options.appearance.structure = 0.0;
    CoordinateMap here;
    if (!testing_support::error_of([&] { here = transfer(input, options).coordinates; }).empty()) continue;
    ++num_transferred;
    for (const DeviceInfo& info : all) {
      input.device = std::make_shared<const SearchDevice>(
          Device(info), [](const device::DeviceError& error) { ADD_FAILURE() << error.what(); });
      EXPECT_EQ(transfer(input, options).coordinates, here) << info.name << ", round " << round;
    }
  }
  EXPECT_GT(num_transferred, kRounds / 2) << "most are refused: the test looks at little";
}

// Before anything travels: no device is opened in this test.
TEST(TransferOfNumbersThatAreNone, IsRefusedNamingThem) {
  RandomStream random(48, 0);
  const float none = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
  TransferInput input{
      .history = any_history(random),
      .map = std::make_shared<const TexelMap>(testing_support::unit_plane(kAnySize), kAnySize, kAnySize),
      .texel_size_mm = 1.0,
      .controls = {}};
  input.controls.push_back({"x", "any", ImageF(kAnySize, kAnySize, 1, 0.5f), {}, 1.0, ControlMapping::Rank});
  const auto said = [&](const auto& change) {
    TransferInput changed = input;
    change(changed);
    return testing_support::error_of<InvalidInput>([&] { (void)transfer(changed); });
  };
  EXPECT_EQ(said([](TransferInput&) {}), "");
  for (const float wrong : {none, infinity, -infinity}) {
    EXPECT_NE(said([&](TransferInput& i) { i.controls[0].values.at(20, 30) = wrong; }).find("texel (20, 30) holds NaN"),
              std::string::npos);
    const auto number = static_cast<double>(wrong);
    EXPECT_NE(said([&](TransferInput& i) { i.controls[0].weight = number; }).find("weight"), std::string::npos);
    EXPECT_NE(said([&](TransferInput& i) { i.texel_size_mm = number; }).find("texel_size_mm"), std::string::npos);
    EXPECT_NE(said([&](TransferInput& i) {
                FlowFrames frames = uv_frames(*i.map);
                frames.front()(0, 0) = number;
                i.frames = std::make_shared<const FlowFrames>(std::move(frames));
              }).find("flow"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace patinate::transfer
