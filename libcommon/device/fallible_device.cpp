#include "libcommon/device/fallible_device.h"

#include <utility>

namespace patinate::device {

FallibleDevice::FallibleDevice(const Device& device, std::function<void(const DeviceError&)> on_failure)
    : device_(device), on_failure_(std::move(on_failure)) {}

void FallibleDevice::report_failure(const DeviceError& error) const {
  if (!has_failed_.exchange(true) && on_failure_) on_failure_(error);
}

}  // namespace patinate::device
