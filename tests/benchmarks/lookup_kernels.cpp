#include "tests/benchmarks/lookup_kernels.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/core/random.h"
#include "libcommon/device/device.h"
#include "libcommon/device/device_choice.h"
#include "tests/benchmarks/patch_transfer.h"
#include "transfer/lookup/lookup_device.h"

namespace patinate::benchmarks {

namespace {

constexpr int kAtlas = 4096, kLargeSource = 4096;
constexpr std::size_t kTexels = std::size_t{kAtlas} * kAtlas;
constexpr int kBuffers = 4;  ///< So many in turn: together larger than any cache.
constexpr int kRounds = 15;

constexpr std::string_view kCopy = R"(
kernel void copy(const ulong num, global const uint4* from, global uint4* to) {
  const ulong item = get_global_id(0);
  if (item < num) to[item] = from[item];
}
)";

/// gather_3_of_4 of lookup_device.cl another way: a group lays its words out beside one another first, so that
/// neighbors write neighbors and sectors of 32 bytes are written once. Whole groups without a texel that shows nothing
/// alone.
constexpr std::string_view kGrouped = R"(
kernel __attribute__((reqd_work_group_size(64, 1, 1))) void gather_grouped(
    global const uint4* indices, global const uint* source, global uint* values) {
  local uint words[192];
  const uint place = (uint)get_local_id(0);
  const uint4 at = indices[get_global_id(0)];
  const uint a = source[at.x], b = source[at.y], c = source[at.z], d = source[at.w];
  words[3 * place] = a | b << 24;
  words[3 * place + 1] = b >> 8 | c << 16;
  words[3 * place + 2] = c >> 16 | d << 8;
  barrier(CLK_LOCAL_MEM_FENCE);
  global uint* to = values + 192 * get_group_id(0);
  for (uint k = place; k < 192; k += 64) to[k] = words[k];
}
)";

/// Seconds of a device's kernels, of each of kBuffers calls of `queue`; the median of kRounds.
double kernel_seconds(const device::Device& device, const std::function<void(std::size_t buffer)>& queue) {
  std::array<double, kRounds + 1> rounds{};
  for (double& seconds : rounds) {
    const double before = device.times().kernels_s;
    for (std::size_t b = 0; b < kBuffers; ++b) queue(b);
    device.finish();
    seconds = (device.times().kernels_s - before) / kBuffers;
  }
  std::sort(rounds.begin() + 1, rounds.end());  // The first warms up.
  return rounds[1 + kRounds / 2];
}

/// GB/s of reading and writing.
double copy_speed(const device::Device& device) {
  constexpr std::size_t kSize = 4 * kTexels;  // Bytes.
  const std::array<std::string_view, 1> sources{kCopy};
  device::Kernel kernel = device.build("copy", sources).kernel("copy");
  std::vector<device::Buffer<std::uint8_t>> from, to;
  for (int b = 0; b < kBuffers; ++b) {
    from.push_back(device.allocate<std::uint8_t>(kSize));
    device.fill_zero(from.back().memory());
    to.push_back(device.allocate<std::uint8_t>(kSize));
  }
  const std::uint64_t items = kSize / 16;
  const double seconds = kernel_seconds(
      device, [&](std::size_t b) { kernel.run({.first = 0, .num = items, .group = 64}, items, from[b], to[b]); });
  return 2e-9 * kSize / seconds;
}

struct Places {
  const char* name;
  int source_px;
  std::vector<std::uint32_t> indices;
};

/// Pieces of 32 x 32 of a small source, as transfers are; and any pixel of a source that no cache holds.
std::vector<Places> all_places() {
  const transfer::PackedCoordinates patches =
      transfer::pack_coordinates(patch_coordinates(kAtlas, false), kPatchSource, kPatchSource).pixels;
  std::vector<Places> all{
      {"pieces of 32 x 32", kPatchSource, {patches.values().begin(), patches.values().end()}},
      {"any pixels of a 4k source", kLargeSource, std::vector<std::uint32_t>(kTexels)},
  };
  RandomStream random(7, 0);
  for (std::uint32_t& index : all[1].indices) index = random.below(kLargeSource * kLargeSource);
  return all;
}

template <class T>
void measure(const device::Device& device, const Places& places, int channels, double copied, const char* values) {
  transfer::DeviceGather<T> gather(device, Image<T>(places.source_px, places.source_px, channels));
  const std::size_t pixel = sizeof(T) * static_cast<std::size_t>(channels);
  std::vector<device::Buffer<std::uint32_t>> indices;
  std::vector<device::Buffer<T>> out;
  for (int b = 0; b < kBuffers; ++b) {
    indices.push_back(device.upload(places.indices));
    out.push_back(device.allocate<T>(kTexels * static_cast<std::size_t>(channels)));
  }
  const double seconds = kernel_seconds(device, [&](std::size_t b) { gather.queue(indices[b], kTexels, out[b]); });
  const double moved = 1e-9 * static_cast<double>(kTexels * (4 + 2 * pixel)) / seconds;
  std::printf(
      "4k, %s, %d %s, %s: kernel %.3f ms, %.1f G texels/s, %.0f GB/s (index, pixel, value), %.0f %% of a copy\n",
      device.info().name.c_str(), channels, values, places.name, 1e3 * seconds, 1e-9 * kTexels / seconds, moved,
      100.0 * moved / copied);
}

void measure_grouped(const device::Device& device, const Places& places, double copied) {
  const std::array<std::string_view, 1> sources{kGrouped};
  device::Kernel kernel = device.build("gather_grouped", sources).kernel("gather_grouped");
  const auto source = device.upload(std::vector<std::uint32_t>(static_cast<std::size_t>(places.source_px) *
                                                               static_cast<std::size_t>(places.source_px)));
  std::vector<device::Buffer<std::uint32_t>> indices, out;
  for (int b = 0; b < kBuffers; ++b) {
    indices.push_back(device.upload(places.indices));
    out.push_back(device.allocate<std::uint32_t>(3 * kTexels / 4));
  }
  const double seconds = kernel_seconds(device, [&](std::size_t b) {
    kernel.run({.first = 0, .num = kTexels / 4, .group = 64}, indices[b], source, out[b]);
  });
  const double moved = 1e-9 * static_cast<double>(kTexels * 10) / seconds;
  std::printf("  3 bytes written by groups: kernel %.3f ms, %.0f GB/s, %.0f %% of a copy\n", 1e3 * seconds, moved,
              100.0 * moved / copied);
}

void measure_device(const device::Device& device, const std::vector<Places>& all) {
  const double copied = copy_speed(device);
  std::printf("%s: a plain copy of 64 MB moves %.0f GB/s, read and written\n", device::label(device.info()).c_str(),
              copied);
  for (const Places& places : all) {
    for (const int channels : {1, 2, 3, 4}) measure<std::uint8_t>(device, places, channels, copied, "bytes");
    measure_grouped(device, places, copied);
    for (const int channels : {1, 3, 4}) measure<float>(device, places, channels, copied, "floats");
  }
}

}  // namespace

void measure_lookup_kernels() {
  const std::vector<Places> all = all_places();
  for (const device::DeviceInfo& info : device::list_devices()) {
    try {
      measure_device(device::Device(info), all);
    } catch (const device::DeviceError& error) {
      std::printf("%s\n", error.what());
    }
  }
}

}  // namespace patinate::benchmarks
