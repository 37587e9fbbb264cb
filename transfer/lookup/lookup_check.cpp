#include <optional>
#include <utility>

#include "libcommon/core/random.h"
#include "patinate/history/memory_history.h"
#include "patinate/transfer/time_map.h"
#include "transfer/lookup/lookup_device.h"
#include "transfer/lookup/packed_lookup.h"

namespace patinate::transfer {

namespace {

constexpr int kSource_px = 32, kFrames = 5;
constexpr int kTexels = 4095;  // Of which the last items of a gather have fewer than others.

MemoryHistory check_history() {
  MemoryHistoryImages images{.name = "check", .frames = {}};
  RandomStream random(11, 0);
  for (int f = 0; f < kFrames; ++f) {
    ImageF color(kSource_px, kSource_px, 3);
    for (float& c : color.values()) c = static_cast<float>(random.uniform());
    images.frames.push_back({.time = 1.5 * f * f, .color = std::move(color)});
  }
  return MemoryHistory(std::move(images));
}

/// Any pixels, every ninth texel none, and any times, some of frames and beyond the ends.
struct CheckTexels {
  PackedCoordinates indices{kTexels, 1};
  ImageF times{kTexels, 1};

  CheckTexels() {
    RandomStream random(11, 1);
    for (int x = 0; x < kTexels; ++x) {
      indices.at(x, 0) = x % 9 == 0 ? kNoValue : random.below(kSource_px * kSource_px);
      times.at(x, 0) =
          x % 5 == 0 ? static_cast<float>(1.5 * (x % 7)) : static_cast<float>(30.0 * random.uniform() - 3.0);
    }
  }
};

template <class T>
Image<T> gathered(const device::Device& device, const Image<T>& source, const PackedCoordinates& indices) {
  Image<T> out(indices.width(), indices.height(), source.channels());
  DeviceGather<T>(device, source).gather(device.upload(indices.values()), out.values());
  return out;
}

template <class T>
void compare(const Image<T>& here, const Image<T>& there, device::CheckResult& check) {
  for (int x = 0; x < kTexels; ++x) {
    bool is_equal = true;
    for (int c = 0; c < here.channels(); ++c) is_equal = is_equal && here.at(x, 0, c) == there.at(x, 0, c);
    check.num_different += is_equal ? 0 : 1;
  }
  check.num_items += kTexels;
}

}  // namespace

device::CheckResult check_lookups(const device::Device& device) {
  const MemoryHistory history = check_history();
  const CheckTexels texels;
  device::CheckResult check;
  RandomStream random(11, 2);
  for (int channels = 1; channels <= 4; ++channels) {
    ImageF values(kSource_px, kSource_px, channels);
    ImageU8 codes(kSource_px, kSource_px, channels);
    for (float& value : values.values()) value = static_cast<float>(random.uniform());
    for (std::uint8_t& code : codes.values()) code = static_cast<std::uint8_t>(random.below(256));
    compare(gather_packed(values, texels.indices), gathered(device, values, texels.indices), check);
    compare(gather_packed(codes, texels.indices), gathered(device, codes, texels.indices), check);
  }

  std::optional<device::DeviceError> failure;
  // Three frames have room at once.
  constexpr std::int64_t kThreeFrames = std::int64_t{3} * kSource_px * kSource_px * 4 * sizeof(float);
  const auto at_times = [&](std::shared_ptr<const LookupDevice> looked_up_by) {
    return gather_at_times(history, PackedPlaces{texels.indices, {}}, texels.times, Between::Blend, {},
                           {.frame_bytes = kThreeFrames, .device = std::move(looked_up_by)});
  };
  const auto there =
      std::make_shared<const LookupDevice>(device, [&](const device::DeviceError& problem) { failure = problem; });
  compare(at_times(nullptr), at_times(there), check);
  if (failure) throw device::DeviceError(*failure);
  return check;
}

}  // namespace patinate::transfer
