#include "transfer/synthesis/search_device.h"

#include <gtest/gtest.h>

#include <string>

#include "libcommon/core/random.h"
#include "patinate/atlas/direction_field.h"
#include "tests/support/histories.h"
#include "tests/support/lost_device.h"
#include "tests/support/meshes.h"
#include "tests/support/on_devices.h"
#include "tests/support/temp_folder.h"

namespace patinate::transfer {
namespace {

using device::Device;
using device::DeviceInfo;
using testing_support::TempFolder;

// A device's neighbors are those of the CPU: on charts of several densities, turned and mirrored, so that some follow
// the grid and some are stored.
TEST(FlatNeighbors, AreThoseThatACursorFinds) {
  const TexelMap map(testing_support::patchwork_plane(96.0, 4), 96, 96);
  const auto frames = std::make_shared<const FlowFrames>(uv_frames(map));
  const TexelNeighborhood neighborhood(map, testing_support::square_offsets(2, 1.3), frames, 1.3);
  const FlatNeighbors flat = neighborhood.flat();
  const std::vector<std::int32_t> triangles = map.triangles();
  const neighbor_kernel::NeighborTables tables{.num = static_cast<std::int32_t>(neighborhood.size()),
                                               .row = flat.row.data(),
                                               .is_stored = flat.is_stored.data(),
                                               .begin = flat.begin.data(),
                                               .stored = flat.stored.data(),
                                               .triangle = triangles.data(),
                                               .steps_of = flat.steps_of.data(),
                                               .steps = flat.steps.data()};
  TexelNeighborhood::Cursor cursor(neighborhood);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const auto expected = cursor.at(t);
    for (std::size_t k = 0; k < expected.size(); ++k) {
      ASSERT_EQ(neighbor_kernel::texel_neighbor(&tables, t, static_cast<std::int32_t>(k)), expected[k])
          << "neighbor " << k << " of texel " << t;
    }
  }
  EXPECT_FALSE(flat.stored.empty());
  EXPECT_FALSE(flat.steps.empty());
}

class SearchOnDevices : public testing_support::OnDevices<> {};

TEST_F(SearchOnDevices, PassesItsOwnCheck) {
  for (const DeviceInfo& info : all) {
    const device::CheckResult check = check_search(Device(info));
    EXPECT_TRUE(check.is_passed()) << info.name << ": " << check.num_different << " of " << check.num_items;
  }
}

/// A history of blotches onto charts that are turned, mirrored and of two densities, with one control or two.
struct QuiltTask {
  TempFolder folder;
  TransferInput input;

  explicit QuiltTask(int num_controls, int num_frames = 4) {
    constexpr int kSource = 72, kSize = 96;
    testing_support::write_history(folder.path(), kSource, kSource, num_frames, testing_support::blotches);
    input.history = std::make_shared<const HistoryReader>(folder.path());
    input.map = std::make_shared<const TexelMap>(testing_support::patchwork_plane(kSize, 4), kSize, kSize);
    input.texel_size_mm = 1.0;
    for (int c = 0; c < num_controls; ++c) {
      ImageF values(kSize, kSize);
      for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) values.at(x, y) = static_cast<float>(c == 0 ? x : y) / kSize;
      }
      const std::string name = c == 0 ? "x" : "y";
      input.controls.push_back({name, name, std::move(values), {0.0, kSource - 1.0, "px"}, 1.0, ControlMapping::Rank});
    }
  }
  [[nodiscard]] TransferResult run(std::shared_ptr<const SearchDevice> device,
                                   const TransferOptions& options = {}) const {
    TransferInput there = input;
    there.device = std::move(device);
    return transfer(there, options);
  }
};

TEST_F(SearchOnDevices, GivesTheCpusCoordinates) {
  for (const int num_controls : {1, 2}) {
    const QuiltTask task(num_controls);
    const TransferResult here = task.run(nullptr);
    for (const DeviceInfo& info : all) {
      std::string failure;
      const auto search = std::make_shared<const SearchDevice>(
          Device(info), [&](const device::DeviceError& error) { failure = error.what(); });
      const TransferResult there = task.run(search);
      EXPECT_EQ(there.coordinates, here.coordinates) << info.name;
      EXPECT_EQ(there.energy.coherence, here.energy.coherence) << "summed up there";
      EXPECT_EQ(there.energy.control_mismatch, here.energy.control_mismatch);
      EXPECT_EQ(failure, "");
    }
  }
}

// Drivers of CPUs have what the items of a group keep on a stack, which the largest neighborhood must not exhaust.
TEST_F(SearchOnDevices, HaveRoomForTheLargestNeighborhood) {
  const QuiltTask task(1);
  const TransferOptions options{.neighborhood_radius_px = 5};
  const CoordinateMap here = task.run(nullptr, options).coordinates;
  for (const DeviceInfo& info : all)
    EXPECT_EQ(task.run(std::make_shared<const SearchDevice>(Device(info)), options).coordinates, here) << info.name;
}

TEST_F(SearchOnDevices, ATransferWhoseDeviceIsLostGoesOnWithTheSameCoordinates) {
  const QuiltTask task(1);
  const TransferResult here = task.run(nullptr);
  for (const int num_launches : {0, 3, 60}) {
    std::vector<std::string> failures;
    const auto search = std::make_shared<const SearchDevice>(
        Device(all[0], testing_support::driver_with_launches(num_launches)),
        [&](const device::DeviceError& error) { failures.emplace_back(error.what()); });
    const TransferResult there = task.run(search);
    EXPECT_EQ(there.coordinates, here.coordinates) << num_launches;
    EXPECT_EQ(there.energy.energy, here.energy.energy) << num_launches;
    ASSERT_EQ(failures.size(), 1U) << "said once";
    EXPECT_NE(failures[0].find("CL_OUT_OF_RESOURCES"), std::string::npos) << failures[0];
  }
}

TEST_F(SearchOnDevices, ATransferThatNeedsMoreMemoryThanTheDeviceHasGoesOnWithoutIt) {
  const QuiltTask task(1);
  DeviceInfo small = all[0];
  small.largest_buffer_bytes = 4096;
  std::string failure;
  const auto search = std::make_shared<const SearchDevice>(
      Device(small), [&](const device::DeviceError& error) { failure = error.what(); });
  EXPECT_EQ(task.run(search).coordinates, task.run(nullptr).coordinates);
  EXPECT_NE(failure.find("too little memory"), std::string::npos) << failure;
}

}  // namespace
}  // namespace patinate::transfer
