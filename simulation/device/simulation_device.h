/// \file
/// The device that a simulation runs on, as far as it does.
#pragma once

#include <atomic>
#include <functional>

#include "libcommon/device/device.h"

namespace patinate::simulation {

/// What it cannot do (DeviceError) the CPU does, from then on all of it. Thread-safe.
class SimulationDevice {
 public:
  /// @param on_failure  Called once, when the CPU goes on; may be empty.
  explicit SimulationDevice(const device::Device& device,
                            std::function<void(const device::DeviceError&)> on_failure = {});
  [[nodiscard]] const device::Device& device() const { return device_; }
  void report_failure(const device::DeviceError& error) const;
  /// Whether something has failed.
  [[nodiscard]] bool has_failed() const { return has_failed_; }

 private:
  device::Device device_;
  std::function<void(const device::DeviceError&)> on_failure_;
  mutable std::atomic<bool> has_failed_{false};
};

}  // namespace patinate::simulation
