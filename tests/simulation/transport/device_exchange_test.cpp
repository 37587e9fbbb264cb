#include "simulation/transport/device_exchange.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "libcommon/core/random.h"
#include "simulation/transport/exchange.h"
#include "tests/simulation/transport/transport_scene.h"
#include "tests/support/lost_device.h"
#include "tests/support/on_devices.h"

namespace patinate::simulation {
namespace {

using device::Device;
using device::DeviceInfo;
using testing_support::random_cargo;
using testing_support::random_contacts;
using testing_support::TransportScene;

constexpr std::uint64_t kSeed = 11;
constexpr std::uint32_t kGammatons = 3000;

class ExchangeOnDevices : public testing_support::OnDevices<> {};

TEST_F(ExchangeOnDevices, PassesItsOwnCheck) {
  for (const DeviceInfo& info : all) {
    const device::CheckResult check = check_exchange(Device(info));
    EXPECT_TRUE(check.is_passed()) << info.name << ": " << check.num_different << " of " << check.num_items;
  }
}

/// One of the two sides that are compared.
struct Side {
  Side(TransportScene given, bool has_maps) : scene(std::move(given)), exchanger(3, kSeed) {
    cargo = random_cargo(kGammatons, 3.9, 2);
    ParameterMapChoice choice;
    if (has_maps) choice = {.hits = true, .last_hit = true, .residence = true, .deposited = {true, false, true}};
    maps = std::make_unique<ParameterMaps>(scene.surface->grid(), choice);
  }
  TransportScene scene;
  Exchanger exchanger;
  Cargo cargo;
  std::unique_ptr<ParameterMaps> maps;
};

/// What both have is the same; pages that are not there, too.
void expect_equal(const Side& a, const Side& b) {
  EXPECT_EQ(a.cargo.mass, b.cargo.mass);
  EXPECT_EQ(a.scene.atlas->hash(), b.scene.atlas->hash());
  for (int m = 0; m < 3; ++m) {
    for (std::uint32_t p = 0; p < a.scene.surface->grid().num_pages(); ++p)
      EXPECT_EQ(a.scene.atlas->page(m, p).empty(), b.scene.atlas->page(m, p).empty()) << m << " " << p;
  }
  for (const TexelIndex t : a.scene.covered) {
    if (a.maps->hits()) {
      EXPECT_EQ(a.maps->hits()->value(t), b.maps->hits()->value(t));
      EXPECT_EQ(a.maps->last_hit()->value(t), b.maps->last_hit()->value(t));
      EXPECT_EQ(a.maps->residence()->value(t), b.maps->residence()->value(t));
      EXPECT_EQ(a.maps->deposited(2)->value(t), b.maps->deposited(2)->value(t));
    }
  }
}

// On unequal areas and across seams, crowded on few texels, with drops of one texel to the widest; between exchanges
// the CPU changes some tiles.
TEST_F(ExchangeOnDevices, GivesTheCpusBytes) {
  RandomStream random(8, 0);
  for (const auto make : {testing_support::squeezed_plane, testing_support::seamed_plane}) {
    for (const double splat_texels : {0.0, 2.0, 9.0, SplatShape::kWidest}) {
      // The widest have more pieces than maps are told of from a device.
      const bool has_maps = splat_texels < SplatShape::kWidest;
      Side here(make(128), has_maps), there(make(128), has_maps);
      const Device device(all[0]);
      there.exchanger.use(std::make_shared<const SimulationDevice>(
          device, [](const device::DeviceError& problem) { ADD_FAILURE() << problem.what(); }));
      for (std::int64_t i = 0; i < 5; ++i) {
        const ExchangeOptions options{.ratio = 0.25 * static_cast<double>(i),
                                      .rates = {random.uniform(), 1.0 / 4096.0, i == 3 ? 0.0 : 1.0},
                                      .contact = 2.0 * random.uniform(),
                                      .splat_mm = splat_texels * here.scene.surface->median_texel_size_mm()};
        const std::vector<Contact> contacts =
            random_contacts(here.scene, kGammatons, static_cast<std::uint64_t>(i), i == 2 ? 4000 : 1);
        const TileIndex tile = TileGrid::tile_of(contacts[0].texel);
        for (Side* side : {&here, &there}) {
          (void)side->exchanger.exchange(contacts, options, i, side->cargo, *side->scene.atlas, side->maps.get());
          side->scene.atlas->writable_tile(1, tile)[7] = static_cast<std::uint16_t>(1000 * i);
          side->exchanger.note_changes(std::span(&tile, 1));
        }
      }
      expect_equal(here, there);
      EXPECT_GT(device.times().kernels_s, 0.0);
    }
  }
}

// Lost before it begins, between two of its kernels, and in a later exchange.
TEST_F(ExchangeOnDevices, LeavesItToTheCpuWhenItIsLost) {
  for (const int num_launches : {0, 1, 3, 8}) {
    Side here(testing_support::seamed_plane(128), false), there(testing_support::seamed_plane(128), false);
    int num_failures = 0;
    there.exchanger.use(
        std::make_shared<const SimulationDevice>(Device(all[0], testing_support::driver_with_launches(num_launches)),
                                                 [&](const device::DeviceError&) { ++num_failures; }));
    for (std::int64_t i = 0; i < 3; ++i) {
      const ExchangeOptions options{.ratio = 0.4, .rates = {0.5, 0.1, 1.0}, .splat_mm = 4.0};
      const auto contacts = random_contacts(here.scene, kGammatons, static_cast<std::uint64_t>(i));
      (void)here.exchanger.exchange(contacts, options, i, here.cargo, *here.scene.atlas);
      (void)there.exchanger.exchange(contacts, options, i, there.cargo, *there.scene.atlas);
    }
    expect_equal(here, there);
    EXPECT_EQ(num_failures, 1) << num_launches;
  }
}

}  // namespace
}  // namespace patinate::simulation
