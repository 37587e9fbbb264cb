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
  /// "kernels 0.12 ms, copies 3.4 ms (12 MB, 7 of them)" of each of `num` runs, and the kernels that took most.
  [[nodiscard]] std::string text(int num) const {
    const device::DeviceTimes after = device_.times();
    const auto each = static_cast<double>(num);
    char line[160];
    std::snprintf(line, sizeof(line), "kernels %.3f ms, copies %.3f ms (%.1f MB, %.1f of them)",
                  1e3 * (after.kernels_s - before_.kernels_s) / each, 1e3 * (after.copies_s - before_.copies_s) / each,
                  1e-6 * static_cast<double>(after.copied_bytes - before_.copied_bytes) / each,
                  static_cast<double>(after.num_copies - before_.num_copies) / each);
    std::string text = line;
    for (const auto& [name, kernel] : after.kernels) {
      device::DeviceTimes::Kernel since = kernel;
      if (const auto before = before_.kernels.find(name); before != before_.kernels.end()) {
        since.seconds -= before->second.seconds;
        since.num_launches -= before->second.num_launches;
      }
      if (since.num_launches == 0) continue;
      std::snprintf(line, sizeof(line), "; %s %.4f ms in %.1f", name.c_str(), 1e3 * since.seconds / each,
                    static_cast<double>(since.num_launches) / each);
      text += line;
    }
    return text;
  }

 private:
  device::Device device_;
  device::DeviceTimes before_;
};

}  // namespace patinate::benchmarks
