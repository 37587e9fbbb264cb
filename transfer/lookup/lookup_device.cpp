#include "transfer/lookup/lookup_device.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/error.h"

namespace patinate::transfer {

using device::Buffer;
using device::Device;
using device::Items;
using lookup_kernel::kPixelSize;
using lookup_kernel::TimesNumbers;

extern const std::string_view kLookupKernel, kLookupEntries;

namespace {

device::Program build_program(const Device& device) {
  const std::array<std::string_view, 3> sources{kFrameKernel, kLookupKernel, kLookupEntries};
  return device.build("lookups", sources);
}

constexpr std::uint64_t kGroup = 64;
constexpr std::size_t kTexelsOfItem = 4;  // Of gathers.

/// Calls launch(items) until all `num` are done: one takes a few milliseconds of the slowest GPU.
template <class Launch>
void for_each_launch(std::uint64_t num, const Launch& launch) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 22;
  for (std::uint64_t first = 0; first < num; first += kMost) {
    const std::uint64_t some = std::min(kMost, num - first);
    launch(Items{.first = first, .num = (some + kGroup - 1) / kGroup * kGroup, .group = kGroup});
  }
}

/// Makes it hold at least `size`.
template <class T>
void make_room(const Device& device, std::size_t size, Buffer<T>& buffer) {
  if (buffer.size() < size) buffer = device.allocate<T>(size);
}

/// Three channels are padded to four.
std::size_t stored_channels(std::size_t channels) { return channels == 3 ? 4 : channels; }

template <class T>
std::string gather_name(const Image<T>& source) {
  const auto channels = static_cast<std::size_t>(source.channels());
  if (channels < 1 || channels > 4) throw InvalidInput("lookup: expected a source of 1 to 4 channels");
  std::string name = "gather_" + std::to_string(channels * sizeof(T));
  if (channels == 3) name += "_of_" + std::to_string(stored_channels(channels) * sizeof(T));
  return name;
}

template <class T>
Buffer<T> uploaded(const Device& device, const Image<T>& source) {
  if (source.channels() != 3) return device.upload(source.values());
  std::vector<T> padded(stored_channels(3) * static_cast<std::size_t>(source.num_pixels()));
  const T* from = source.data();
  for (std::size_t i = 0; i < padded.size(); i += 4, from += 3) std::copy_n(from, 3, &padded[i]);
  return device.upload(padded);
}

}  // namespace

template <class T>
DeviceGather<T>::DeviceGather(const Device& device, const Image<T>& source)
    : device_(device),
      kernel_(build_program(device).kernel(gather_name(source))),
      channels_(static_cast<std::size_t>(source.channels())),
      source_(uploaded(device, source)) {}

template <class T>
void DeviceGather<T>::queue(const Buffer<std::uint32_t>& indices, std::size_t num_texels, const Buffer<T>& values) {
  for_each_launch((num_texels + kTexelsOfItem - 1) / kTexelsOfItem, [&](const Items& items) {
    kernel_.run(items, static_cast<std::uint64_t>(num_texels), indices, source_, values);
  });
}

template <class T>
void DeviceGather<T>::gather(const Buffer<std::uint32_t>& indices, std::span<T> values) {
  make_room(device_, values.size(), values_);
  queue(indices, values.size() / channels_, values_);
  device_.read(values_, values);
}

template class DeviceGather<float>;
template class DeviceGather<std::uint8_t>;

ImageF gather_on(const LookupDevice* device, const ImageF& source, const PackedPlaces& places,
                 const RunControl& control) {
  constexpr std::size_t kStripTexels = std::size_t{1} << 24;
  if (device == nullptr || device->has_failed() || !places.beside.empty())
    return gather_packed(source, places, 0.0f, control);
  try {
    const auto turn = device->turn();
    const auto channels = static_cast<std::size_t>(source.channels());
    ImageF out(places.pixels.width(), places.pixels.height(), source.channels());
    DeviceGather<float> gatherer(device->device(), source);
    const std::span<const std::uint32_t> all = places.pixels.values();
    for (std::size_t begin = 0; begin < all.size(); begin += kStripTexels) {
      control.throw_if_stopped();
      const auto strip = all.subspan(begin, std::min(kStripTexels, all.size() - begin));
      gatherer.gather(device->device().upload(strip), out.values().subspan(channels * begin, channels * strip.size()));
    }
    control.report(1.0);
    return out;
  } catch (const device::DeviceError& error) {
    device->report_failure(error);
    return gather_packed(source, places, 0.0f, control);
  }
}

struct DeviceTimes::State {
  State(const Device& its_device, const FrameLocator& locator, std::int64_t num_pixels, int frames_of_block)
      : device(its_device),
        program(build_program(device)),
        mark(program.kernel("mark_frames")),
        look_up(program.kernel("look_up_times")),
        per_block(frames_of_block) {
    const frame_kernel::FrameTimes tables = locator.tables();
    numbers.num_pixels = static_cast<std::uint64_t>(num_pixels);
    numbers.bins_per_time = tables.bins_per_time;
    numbers.num_times = tables.num_times;
    numbers.num_bins = tables.num_bins;
    numbers.between = tables.between;
    frame_times = device.upload(std::span(tables.times, static_cast<std::size_t>(tables.num_times)));
    bins = device.upload(std::span(tables.first, static_cast<std::size_t>(tables.num_bins)));
    const auto room = static_cast<std::size_t>(std::min(per_block + 1, tables.num_times));
    is_there.assign(room, 0);
    is_needed = device.allocate<std::uint8_t>(room);
    frames = device.allocate<float>(room * pixel_numbers());
  }
  [[nodiscard]] std::size_t pixel_numbers() const { return kPixelSize * static_cast<std::size_t>(numbers.num_pixels); }

  Device device;
  device::Program program;
  device::Kernel mark, look_up;
  int per_block;
  TimesNumbers numbers{};
  std::vector<std::uint8_t> is_there;  ///< By frame of the block.
  Buffer<double> frame_times;
  Buffer<std::int32_t> bins;
  Buffer<std::uint8_t> is_needed;
  Buffer<float> frames, times, colors;
  Buffer<std::uint32_t> indices;

  /// Frames that texels of the block look at, and that are not there.
  void fetch(const ReadFrame& read) {
    const auto last = std::min(numbers.end + 1, numbers.num_times) - numbers.first;
    if (std::all_of(is_there.begin(), is_there.begin() + last, [](std::uint8_t is) { return is != 0; })) return;
    device.fill_zero(is_needed.memory());
    for_each_launch(numbers.num_texels, [&](const Items& items) {
      mark.run(items, numbers, frame_times, bins, indices, times, is_needed);
    });
    std::vector<std::uint8_t> needed(is_needed.size());
    device.read(is_needed, std::span(needed));
    std::vector<float> pixels(pixel_numbers());
    for (std::size_t k = 0; k < needed.size(); ++k) {
      if (needed[k] == 0 || is_there[k] != 0) continue;
      const ImageF frame = read(numbers.first + static_cast<int>(k));
      const float* from = frame.data();
      for (std::size_t i = 0; i < pixels.size(); i += kPixelSize, from += 3) std::copy_n(from, 3, &pixels[i]);
      device.write(std::span<const float>(pixels), frames, k * pixels.size());
      is_there[k] = 1;
    }
  }
};

DeviceTimes::DeviceTimes(const Device& device, const FrameLocator& locator, std::int64_t num_pixels, int per_block)
    : state_(std::make_unique<State>(device, locator, num_pixels, per_block)) {}
DeviceTimes::~DeviceTimes() = default;

void DeviceTimes::look_up(std::span<const std::uint32_t> indices, std::span<const float> times, const ReadFrame& read,
                          std::span<float> colors) {
  State& s = *state_;
  s.numbers.num_texels = indices.size();
  make_room(s.device, indices.size(), s.indices);
  make_room(s.device, times.size(), s.times);
  make_room(s.device, colors.size(), s.colors);
  s.device.write(indices, s.indices);
  s.device.write(times, s.times);
  const bool is_one_block = s.per_block >= s.numbers.num_times;
  for (int first = 0; first < s.numbers.num_times; first += s.per_block) {
    if (!is_one_block) std::fill(s.is_there.begin(), s.is_there.end(), std::uint8_t{0});
    s.numbers.first = first;
    s.numbers.end = std::min(first + s.per_block, s.numbers.num_times);
    s.fetch(read);
    for_each_launch(s.numbers.num_texels, [&](const Items& items) {
      s.look_up.run(items, s.numbers, s.frame_times, s.bins, s.indices, s.times, s.frames, s.colors);
    });
  }
  s.device.read(s.colors, colors);
}

}  // namespace patinate::transfer
