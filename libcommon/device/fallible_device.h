/// \file
/// A device that work is given to, and what is done when it fails.
#pragma once

#include <atomic>
#include <functional>

#include "libcommon/device/device.h"

namespace patinate::device {

/// After a DeviceError the CPU does the work, from then on all of it. Thread-safe.
class FallibleDevice {
 public:
  /// @param on_failure  Called once, when the CPU goes on; may be empty.
  explicit FallibleDevice(const Device& device, std::function<void(const DeviceError&)> on_failure = {});
  [[nodiscard]] const Device& device() const { return device_; }
  void report_failure(const DeviceError& error) const;
  /// Whether something has failed.
  [[nodiscard]] bool has_failed() const { return has_failed_; }

 private:
  Device device_;
  std::function<void(const DeviceError&)> on_failure_;
  mutable std::atomic<bool> has_failed_{false};
};

}  // namespace patinate::device
