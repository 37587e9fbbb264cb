/// \file
/// Devices that run our kernels: what there is, memory on one, and programs for it. OpenCL stays behind it.
///
/// Kernels are written once, in the C that both a C++ compiler and OpenCL's read (kernel_language.h), with sums in a
/// fixed order, integers or correctly rounded floats, and no function of a device's math library: a device gives the
/// CPU's bytes, or is refused (checks of its kernels compare a few thousand items).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "patinate/core/error.h"

namespace patinate::device {

struct OpenCl;
struct DeviceState;
struct ProgramState;
struct KernelState;

/// Something that a device could not do. Whoever runs a kernel can do the same on the CPU.
class DeviceError : public CannotComplete {
 public:
  explicit DeviceError(const std::string& what, std::string detail = {})
      : CannotComplete(what), detail_(std::move(detail)) {}
  /// Several lines, may be empty: a compiler's log.
  [[nodiscard]] const std::string& detail() const { return detail_; }

 private:
  std::string detail_;
};

struct DeviceInfo {
  std::string name;      ///< Name as its driver calls it.
  std::string platform;  ///< The driver's.
  std::string version;   ///< Version of the platform: "OpenCL 3.0 PoCL 3.1".
  std::string driver;    ///< Version.
  bool is_gpu = false;   ///< Else a processor or an accelerator.
  int num_units = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t largest_buffer_bytes = 0;
  bool has_doubles = false;
  bool rounds_correctly = false;    ///< Divisions and square roots of floats.
  void* platform_handle = nullptr;  ///< cl_platform_id, valid in this process.
  void* device_handle = nullptr;    ///< cl_device_id.
};

/// All devices of all drivers, in their order; none where there is no OpenCL.
[[nodiscard]] std::vector<DeviceInfo> list_devices();
[[nodiscard]] std::vector<DeviceInfo> list_devices(const OpenCl& functions);

/// Times of a device's work.
struct DeviceTimes {
  struct Kernel {
    std::int64_t num_launches = 0;
    double seconds = 0.0;  ///< By the device's clock.
  };
  double kernels_s = 0.0;  ///< By its own clock: those that were waited for.
  double copies_s = 0.0;   ///< To it and back, by ours.
  std::uint64_t copied_bytes = 0;
  std::int64_t num_copies = 0;
  std::map<std::string, Kernel> kernels;  ///< By name.
};

class Device;

/// Memory on a device, of `size_bytes`. Movable; empty when default-constructed.
class Memory {
 public:
  Memory() = default;
  [[nodiscard]] std::size_t size_bytes() const { return size_bytes_; }

 private:
  friend class Device;
  friend class Kernel;
  std::shared_ptr<void> handle_;  // cl_mem
  std::size_t size_bytes_ = 0;
};

/// An array on a device.
template <class T>
class Buffer {
 public:
  Buffer() = default;
  Buffer(Memory memory, std::size_t size) : memory_(std::move(memory)), size_(size) {}
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const Memory& memory() const { return memory_; }

 private:
  Memory memory_;
  std::size_t size_ = 0;
};

/// Items [first, first + num) of a kernel, in groups of `group` (num is a multiple of it; 0: as the driver likes).
struct Items {
  std::uint64_t first = 0;
  std::uint64_t num = 0;
  std::uint64_t group = 0;
};

/// A function of a Program. Not thread-safe: arguments belong to it.
class Kernel {
 public:
  /// Queues it for some items. Launches should be short, so that a display of the same device stays alive.
  /// @param args  Buffers, and numbers or plain structs of exactly the kernel's types.
  template <class... Args>
  void run(const Items& items, const Args&... args) {
    unsigned index = 0;
    (set(index++, args), ...);
    launch(items);
  }

 private:
  friend class Program;
  explicit Kernel(std::shared_ptr<KernelState> state) : state_(std::move(state)) {}
  template <class T>
  void set(unsigned index, const Buffer<T>& buffer) {
    set_memory(index, buffer.memory());
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void set(unsigned index, const T& value) { set_value(index, &value, sizeof(T)); }
  /// An argument that has this value already is not set again: drivers take their time.
  void set_memory(unsigned index, const Memory& memory);
  void set_value(unsigned index, const void* value, std::size_t size);
  void launch(const Items& items);

  std::shared_ptr<KernelState> state_;
};

/// Compiled kernels.
class Program {
 public:
  /// @throws DeviceError if there is none of that name.
  [[nodiscard]] Kernel kernel(const std::string& name) const;

 private:
  friend class Device;
  explicit Program(std::shared_ptr<ProgramState> state) : state_(std::move(state)) {}
  std::shared_ptr<ProgramState> state_;
};

/// One device with a queue of its own: what is given to it is done in order. Every member throws DeviceError naming the
/// device and what failed. Copies are the same device. Several threads may use it; each has kernels of its own.
class Device {
 public:
  explicit Device(const DeviceInfo& info);
  /// @param functions  Must outlive it.
  Device(const DeviceInfo& info, const OpenCl& functions);

  [[nodiscard]] const DeviceInfo& info() const;
  /// Since it was opened; copies of a Device are the same.
  [[nodiscard]] DeviceTimes times() const;

  /// Memory of arbitrary content.
  template <class T>
  [[nodiscard]] Buffer<T> allocate(std::size_t size) const {
    return Buffer<T>(allocate_bytes(size * sizeof(T)), size);
  }
  template <class T>
  [[nodiscard]] Buffer<T> upload(std::span<const T> values) const {
    Buffer<T> buffer = allocate<T>(values.size());
    write(values, buffer);
    return buffer;
  }
  template <class T>
  [[nodiscard]] Buffer<T> upload(const std::vector<T>& values) const {
    return upload(std::span<const T>(values));
  }
  /// To [first, first + values.size()) of the buffer.
  template <class T>
  void write(std::span<const T> values, Buffer<T>& buffer, std::size_t first = 0) const {
    write_bytes(buffer.memory(), first * sizeof(T), values.data(), values.size_bytes());
  }
  /// Writes without waiting: the values are copied, and kept until finish().
  template <class T>
  void write_soon(std::span<const T> values, const Buffer<T>& buffer) const {
    write_bytes_soon(buffer.memory(), std::as_bytes(values));
  }
  /// Waits for what was queued before. @param values  At most as long as the buffer.
  template <class T>
  void read(const Buffer<T>& buffer, std::span<T> values) const {
    read_bytes(buffer.memory(), values.data(), values.size_bytes());
  }
  void fill_zero(const Memory& memory) const { fill_words(memory, 0); }
  /// With one 4-byte word, again and again; memory of another size than a multiple of 4 with the lowest of its bytes.
  void fill_words(const Memory& memory, std::uint32_t word) const;

  /// Compiles `sources`, one text after the other, behind kernel_language.h, without contraction and with correctly
  /// rounded divisions and roots. What was compiled before is taken from `patinate/kernels` in the user's cache folder,
  /// by the key of sources and driver. @throws DeviceError with the compiler's log.
  [[nodiscard]] Program build(std::string_view name, std::span<const std::string_view> sources) const;

  /// Waits for all that was queued.
  void finish() const;

 private:
  [[nodiscard]] Memory allocate_bytes(std::size_t size) const;
  void write_bytes(const Memory& memory, std::size_t offset, const void* values, std::size_t size) const;
  void write_bytes_soon(const Memory& memory, std::span<const std::byte> values) const;
  void read_bytes(const Memory& memory, void* values, std::size_t size) const;

  std::shared_ptr<DeviceState> state_;
};

}  // namespace patinate::device
