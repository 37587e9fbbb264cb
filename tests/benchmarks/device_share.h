/// \file
/// What a device did while something was measured.
#pragma once

#include <cstdio>
#include <string>

#include "libcommon/device/device.h"

namespace patinate::benchmarks {

/// Reads a device's times when it is made, and says what has come to them since.
class DeviceShare {
 public:
  explicit DeviceShare(const device::Device& device) : device_(device), before_(device.times()) {}
  /// "kernels 0.12 ms, copies 3.4 ms (12 MB)" of each of `num` runs.
  [[nodiscard]] std::string text(int num) const {
    const device::DeviceTimes after = device_.times();
    const auto each = static_cast<double>(num);
    char line[96];
    std::snprintf(line, sizeof(line), "kernels %.3f ms, copies %.3f ms (%.1f MB)",
                  1e3 * (after.kernels_s - before_.kernels_s) / each, 1e3 * (after.copies_s - before_.copies_s) / each,
                  1e-6 * static_cast<double>(after.copied_bytes - before_.copied_bytes) / each);
    return line;
  }

 private:
  device::Device device_;
  device::DeviceTimes before_;
};

}  // namespace patinate::benchmarks
