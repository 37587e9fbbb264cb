/// \file
/// Lookups on a device, with the CPU's bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>

#include "libcommon/device/arithmetic_check.h"
#include "libcommon/device/fallible_device.h"
#include "libcommon/history/frame_locator.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "transfer/lookup/packed_lookup.h"

namespace patinate::transfer {

/// lookup_kernel.inl for C++; devices read the same text.
namespace lookup_kernel {
using namespace kernel_types;
#include "transfer/lookup/lookup_kernel.inl"
}  // namespace lookup_kernel

/// A device for lookups. Several threads may have it, and take turns.
class LookupDevice : public device::FallibleDevice {
 public:
  using FallibleDevice::FallibleDevice;
  /// To be held by whoever gives it work, or reads of it: a device has one queue.
  [[nodiscard]] std::unique_lock<std::mutex> turn() const { return std::unique_lock(mutex_); }

 private:
  mutable std::mutex mutex_;
};

/// gather_packed() of one source (packed_lookup.h), outside 0. @tparam T  float, std::uint8_t.
template <class T>
class DeviceGather {
 public:
  /// @throws DeviceError, as gather(); InvalidInput unless it has 1 to 4 channels.
  DeviceGather(const device::Device& device, const Image<T>& source);
  /// @param indices  Inside the source, or kNoValue. @param values  As many as texels have channels.
  void gather(const device::Buffer<std::uint32_t>& indices, std::span<T> values);
  /// Queues the same into the device's own memory, and does not wait. @param values  Room for all.
  void queue(const device::Buffer<std::uint32_t>& indices, std::size_t num_texels, const device::Buffer<T>& values);

 private:
  device::Device device_;
  device::Kernel kernel_;
  std::size_t channels_;
  device::Buffer<T> source_, values_;
};

/// gather_packed() of a whole image, there or, where `device` is null or fails, or places lie between pixels, here.
/// Outside, 0.
[[nodiscard]] ImageF gather_on(const LookupDevice* device, const ImageF& source, const PackedPlaces& places,
                               const RunControl& control = {});

/// Colors of texels with a time of their own (time_map.h), between frames that stay in a device's memory.
class DeviceTimes {
 public:
  /// A frame of the history, three numbers a pixel.
  using ReadFrame = std::function<ImageF(int frame)>;

  /// @param locator     Of the history's frames; must outlive it. @param num_pixels  Of a frame.
  /// @param per_block   Frames that are kept at once, and one more for blends of the last one; > 0.
  /// @throws DeviceError, as look_up().
  DeviceTimes(const device::Device& device, const FrameLocator& locator, std::int64_t num_pixels, int per_block);
  ~DeviceTimes();

  /// @param indices  Pixels, or kNoValue. @param times  Not NaN where a texel has a pixel.
  /// @param read     Called for frames that are needed and not there.
  /// @param colors   Three a texel, all of them written: 0 where it has no pixel.
  void look_up(std::span<const std::uint32_t> indices, std::span<const float> times, const ReadFrame& read,
               std::span<float> colors);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Gathers of bytes and floats, and a time map over frames that do not fit at once, there and here. @throws DeviceError
/// if the device cannot run them.
[[nodiscard]] device::CheckResult check_lookups(const device::Device& device);

}  // namespace patinate::transfer
