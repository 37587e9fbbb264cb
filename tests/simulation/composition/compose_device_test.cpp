#include "simulation/composition/compose_device.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libcommon/core/random.h"
#include "libcommon/device/device_choice.h"
#include "simulation/device/simulation_device.h"
#include "tests/simulation/composition/compose_scene.h"
#include "tests/support/lost_device.h"
#include "tests/support/meshes.h"
#include "tests/support/on_devices.h"

namespace patinate::simulation {
namespace {

using device::Device;
using device::DeviceInfo;
using testing_support::any_appearance;
using testing_support::ComposeScene;

class ComposeOnDevices : public testing_support::OnDevices<> {};

void expect_equal(const Composer& a, const Composer& b, const std::string& where) {
  EXPECT_TRUE(std::equal(a.codes().begin(), a.codes().end(), b.codes().begin(), b.codes().end())) << where;
  EXPECT_TRUE(std::equal(a.normals().begin(), a.normals().end(), b.normals().begin(), b.normals().end())) << where;
  const ImageF here = a.height_mm(), there = b.height_mm();
  EXPECT_TRUE(std::equal(here.values().begin(), here.values().end(), there.values().begin())) << where;
}

TEST_F(ComposeOnDevices, PassTheirOwnCheck) {
  for (const DeviceInfo& info : all) {
    const device::CheckResult check = check_composition(Device(info));
    EXPECT_TRUE(check.is_passed()) << info.name << ": " << check.num_different << " of " << check.num_items;
  }
}

// Eight materials of every kind on charts that are turned and mirrored, first whole, then where much has changed, then
// with other looks; both forms.
TEST_F(ComposeOnDevices, GiveTheCpusBytes) {
  for (const DeviceInfo& info : all) {
    for (const ColorForm form : {ColorForm::Normalized, ColorForm::Published}) {
      std::vector<MaterialAppearance> looks = any_appearance(8, 5);
      looks[2].grain_mm = 3.0;
      looks[2].second_color = Vec3(0.9, 0.1, 0.2);
      looks[5].grain_mm = 5.0;  // with colors by amount
      looks[3].color.image = ImageF(13, 9, 3);
      for (std::size_t i = 0; i < looks[3].color.image.values().size(); ++i)
        looks[3].color.image.data()[i] = static_cast<float>(i % 17) / 17.0F;
      ComposeScene scene(testing_support::patchwork_plane(60.0, 4), 128, looks);
      testing_support::set_any_amounts(scene, 9);
      Composer here = scene.composer(form), there = scene.composer(form);
      there.use(std::make_shared<const SimulationDevice>(
          Device(info), [&](const device::DeviceError& problem) { ADD_FAILURE() << problem.what(); }));
      EXPECT_EQ(here.compose(*scene.atlas, {}), there.compose(*scene.atlas, {}));
      expect_equal(here, there, info.name + ": whole");
      std::vector<TileIndex> dirty;
      for (TileIndex tile = 0; tile < scene.surface->grid().num_tiles(); tile += 2) {
        for (std::uint16_t& amount : scene.atlas->writable_tile(1, tile))
          amount = static_cast<std::uint16_t>(amount / 2);
        dirty.push_back(tile);
      }
      EXPECT_EQ(here.compose(*scene.atlas, dirty), there.compose(*scene.atlas, dirty));
      expect_equal(here, there, info.name + ": every second tile");
      here.set_appearance(any_appearance(8, 6));
      there.set_appearance(any_appearance(8, 6));
      EXPECT_EQ(here.compose(*scene.atlas, {}), there.compose(*scene.atlas, {}));
      expect_equal(here, there, info.name + ": other looks");
    }
  }
}

// More tiles than a device is given at once: lost before the first colors, between two batches of them, before the
// normals.
TEST_F(ComposeOnDevices, ThatAreLostLeaveTheRestToTheCpu) {
  constexpr int kResolution = 640, kNumBatches = 2;  // 6400 tiles, 4096 at once.
  ComposeScene scene(testing_support::unit_plane(60.0), kResolution, any_appearance(2, 5));
  testing_support::set_any_amounts(scene, 9);
  Composer here = scene.composer();
  const std::vector<TileIndex> changed = here.compose(*scene.atlas, {});
  for (const int num_launches : {0, 1, kNumBatches}) {
    int num_failures = 0;
    Composer there = scene.composer();
    there.use(
        std::make_shared<const SimulationDevice>(Device(all[0], testing_support::driver_with_launches(num_launches)),
                                                 [&](const device::DeviceError&) { ++num_failures; }));
    double fraction = 0.0;
    RunControl control;
    control.on_progress = [&](double f) {
      EXPECT_GE(f, fraction);
      fraction = f;
    };
    EXPECT_EQ(there.compose(*scene.atlas, {}, control), changed) << "what a device had done counts too";
    expect_equal(here, there, std::to_string(num_launches));
    EXPECT_EQ(num_failures, 1);
  }
}

}  // namespace
}  // namespace patinate::simulation
