#include "transfer/lookup/lookup_device.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/transfer/time_map.h"
#include "tests/support/histories.h"
#include "tests/support/lost_device.h"
#include "tests/support/temp_folder.h"
#include "transfer/lookup/packed_lookup.h"

namespace patinate::transfer {
namespace {

using device::Device;
using device::DeviceInfo;

constexpr int kDeviceSource = 16, kFrames = 5, kWidth = 61, kHeight = 33;

/// An atlas that shows any pixels, some texels none, at any times; some are those of frames, some before and after all.
class LookupsOnDevices : public testing::Test {
 protected:
  void SetUp() override {
    if (all.empty()) GTEST_SKIP() << "there is no OpenCL device (Debian: pocl-opencl-icd)";
    testing_support::write_history(folder.path(), kDeviceSource, kDeviceSource, kFrames, testing_support::blotches);
    RandomStream random(5, 0);
    for (std::uint32_t& index : indices.values())
      index = random.below(8) == 0 ? kNoValue : random.below(kDeviceSource * kDeviceSource);
    for (float& time : times.values()) {
      const std::uint32_t kind = random.below(4);
      time = kind == 0 ? static_cast<float>(random.below(kFrames)) : static_cast<float>(6.0 * random.uniform() - 1.0);
    }
  }

  [[nodiscard]] ImageF colors(Between between, std::shared_ptr<const LookupDevice> device,
                              int frames_at_once = 2) const {
    const std::int64_t frame_bytes =
        std::int64_t{kDeviceSource} * kDeviceSource * 4 * static_cast<std::int64_t>(sizeof(float));
    return gather_at_times(HistoryReader(folder.path()), PackedPlaces{indices, {}}, times, between, {},
                           {.frame_bytes = frames_at_once * frame_bytes, .device = std::move(device)});
  }

  std::vector<DeviceInfo> all = device::list_devices();
  testing_support::TempFolder folder;
  PackedCoordinates indices{kWidth, kHeight};
  ImageF times{kWidth, kHeight};
};

TEST_F(LookupsOnDevices, PassTheirOwnCheck) {
  for (const DeviceInfo& info : all) {
    const device::CheckResult check = check_lookups(Device(info));
    EXPECT_TRUE(check.is_passed()) << info.name << ": " << check.num_different << " of " << check.num_items;
  }
}

TEST_F(LookupsOnDevices, OfSourcesWithAnyNumberOfChannelsAreTheCpus) {
  for (const DeviceInfo& info : all) {
    const Device device(info);
    for (int channels = 1; channels <= 4; ++channels) {
      ImageF values(kDeviceSource, kDeviceSource, channels);
      ImageU8 codes(kDeviceSource, kDeviceSource, channels);
      for (std::size_t i = 0; i < values.values().size(); ++i) {
        values.data()[i] = static_cast<float>(i) - 100.5f;
        codes.data()[i] = static_cast<std::uint8_t>(7 * i + 1);
      }
      ImageF found(kWidth, kHeight, channels);
      DeviceGather<float>(device, values).gather(device.upload(std::as_const(indices).values()), found.values());
      EXPECT_EQ(found, gather_packed(values, indices)) << info.name << ' ' << channels;
      ImageU8 found_codes(kWidth, kHeight, channels);
      DeviceGather<std::uint8_t>(device, codes)
          .gather(device.upload(std::as_const(indices).values()), found_codes.values());
      EXPECT_EQ(found_codes, gather_packed(codes, indices)) << info.name << ' ' << channels;
    }
  }
}

/// Any bits, those of NaN, infinities and subnormal numbers among them.
template <class T>
Image<T> any_bits(RandomStream& random, int width, int height, int channels) {
  Image<T> image(width, height, channels);
  std::vector<std::uint8_t> bytes(image.values().size_bytes());
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.below(256));
  std::memcpy(image.data(), bytes.data(), bytes.size());
  return image;
}

template <class T>
void expect_same_bits(const LookupDevice& device, const Image<T>& source, const PackedCoordinates& indices) {
  const Image<T> here = gather_packed(source, indices);
  Image<T> there(indices.width(), indices.height(), source.channels());
  DeviceGather<T>(device.device(), source).gather(device.device().upload(indices.values()), there.values());
  ASSERT_EQ(there.values().size(), here.values().size());
  EXPECT_EQ(std::memcmp(there.data(), here.data(), here.values().size_bytes()), 0)
      << indices.num_pixels() << " texels of " << source.width() << " x " << source.height() << " x "
      << source.channels();
}

// Gathers copy bits: what a number is worth does not count, nor how many texels an item has left for it.
TEST_F(LookupsOnDevices, OfAnyBitsAnyTexelsAndAnySourceAreTheCpus) {
  constexpr int kRounds = 60;
  for (const DeviceInfo& info : all) {
    const LookupDevice device(Device(info),
                              [](const device::DeviceError& problem) { ADD_FAILURE() << problem.what(); });
    RandomStream random(31, 0);
    for (int round = 0; round < kRounds; ++round) {
      const int width = 1 + static_cast<int>(random.below(40)), height = 1 + static_cast<int>(random.below(40)),
                channels = 1 + round % 4;
      const std::uint32_t nothing = random.below(9);  // In 0 to 8 of 8 texels.
      PackedCoordinates texels(round < 12 ? round + 1 : 1 + static_cast<int>(random.below(300)), 1);
      for (std::uint32_t& index : texels.values())
        index = random.below(8) < nothing ? kNoValue : random.below(static_cast<std::uint32_t>(width * height));
      expect_same_bits(device, any_bits<float>(random, width, height, channels), texels);
      expect_same_bits(device, any_bits<std::uint8_t>(random, width, height, channels), texels);
    }
  }
}

TEST_F(LookupsOnDevices, BetweenPixelsAreMadeByTheCpu) {
  const ImageF source(kDeviceSource, kDeviceSource, 3, 0.5f);
  const LookupDevice device(Device(all.front()),
                            [](const device::DeviceError& error) { ADD_FAILURE() << error.what(); });
  const PackedPlaces places{indices, Image<std::uint32_t>(kWidth, kHeight, 1, pack_beside({-3, 90}))};
  EXPECT_EQ(gather_on(&device, source, places), gather_packed(source, places));
}

TEST_F(LookupsOnDevices, OfFiveChannelsAreRefused) {
  EXPECT_THROW(DeviceGather<float>(Device(all[0]), ImageF(4, 4, 5)), InvalidInput);
}

TEST_F(LookupsOnDevices, OfWholeImagesGoOnWithoutOneThatIsLost) {
  const ImageF source(kDeviceSource, kDeviceSource, 3, 0.5f);
  std::string failure;
  const LookupDevice device(Device(all[0], testing_support::driver_with_launches(0)),
                            [&](const device::DeviceError& error) { failure = error.what(); });
  EXPECT_EQ(gather_on(&device, source, PackedPlaces{indices, {}}), gather_packed(source, indices));
  EXPECT_NE(failure.find("CL_OUT_OF_RESOURCES"), std::string::npos) << failure;
}

TEST_F(LookupsOnDevices, AtTimesOfTheirOwnAreTheCpusWhetherFramesFitAtOnceOrNot) {
  for (const DeviceInfo& info : all) {
    const auto device = std::make_shared<const LookupDevice>(
        Device(info), [](const device::DeviceError& problem) { ADD_FAILURE() << problem.what(); });
    for (const Between between : {Between::Blend, Between::Hold, Between::Nearest}) {
      const ImageF here = colors(between, nullptr);
      for (const int frames_at_once : {2, 3, kFrames + 1})
        EXPECT_EQ(colors(between, device, frames_at_once), here) << info.name << ' ' << frames_at_once;
    }
  }
}

TEST_F(LookupsOnDevices, AtTheSmallestAndLargestTimesAreTheCpus) {
  using Limits = std::numeric_limits<float>;
  const std::array<float, 11> extremes{0.0f,
                                       -0.0f,
                                       Limits::denorm_min(),
                                       -Limits::denorm_min(),
                                       Limits::min(),
                                       Limits::max(),
                                       Limits::lowest(),
                                       Limits::infinity(),
                                       -Limits::infinity(),
                                       std::nextafter(kFrames - 1.0f, 0.0f),
                                       std::nextafter(1.0f, 2.0f)};
  for (std::size_t i = 0; i < times.values().size(); ++i) times.data()[i] = extremes[i % extremes.size()];
  for (const DeviceInfo& info : all) {
    const auto device = std::make_shared<const LookupDevice>(Device(info));
    for (const Between between : {Between::Blend, Between::Hold, Between::Nearest})
      EXPECT_EQ(colors(between, device), colors(between, nullptr)) << info.name;
  }
}

TEST_F(LookupsOnDevices, GoOnWithoutOneThatIsLost) {
  const ImageF here = colors(Between::Blend, nullptr);
  for (const int num_launches : {0, 1, 3}) {
    std::vector<std::string> failures;
    const auto device = std::make_shared<const LookupDevice>(
        Device(all[0], testing_support::driver_with_launches(num_launches)),
        [&](const device::DeviceError& error) { failures.emplace_back(error.what()); });
    EXPECT_EQ(colors(Between::Blend, device), here) << num_launches;
    ASSERT_EQ(failures.size(), 1U) << "said once";
    EXPECT_NE(failures[0].find("CL_OUT_OF_RESOURCES"), std::string::npos) << failures[0];
  }
}

TEST_F(LookupsOnDevices, NameTheTexelWhoseTimeIsNoNumber) {
  indices.at(7, 3) = 0;
  times.at(7, 3) = std::nanf("");
  std::string here, there;
  for (std::string* said : {&here, &there}) {
    try {
      (void)colors(Between::Blend, said == &there ? std::make_shared<const LookupDevice>(Device(all[0])) : nullptr);
    } catch (const InvalidInput& error) {
      *said = error.what();
    }
  }
  EXPECT_NE(here.find("(7, 3)"), std::string::npos) << here;
  EXPECT_EQ(there, here);
}

}  // namespace
}  // namespace patinate::transfer
