/// \file
/// Whether a device calculates as the CPU does.
#pragma once

#include "libcommon/device/device.h"

namespace patinate::device {

/// Result of a check of a device's kernels.
struct CheckResult {
  std::int64_t num_items = 0;
  std::int64_t num_different = 0;
  [[nodiscard]] bool is_passed() const { return num_items > 0 && num_different == 0; }
};

/// Products, sums, quotients and square roots of floats and doubles, subnormal ones among them, and whole numbers of 64
/// bit: 4096 items here and there. @throws DeviceError if the device cannot run them.
[[nodiscard]] CheckResult check_arithmetic(const Device& device);

}  // namespace patinate::device
