/// \file
/// What `--device` asks for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libcommon/device/device.h"
#include "patinate/core/options.h"

namespace patinate::device {

/// `auto` (a GPU where it is faster), `cpu`, `gpu`, or a part of a device's name.
struct DeviceOptions {
  std::string device = "auto";
};
void describe(OptionVisitor& v, DeviceOptions& o);

/// "NVIDIA H200 (NVIDIA CUDA)".
[[nodiscard]] std::string label(const DeviceInfo& info);

/// The devices to try, those of most memory first; none: the CPU's own code. `auto`: GPUs, `gpu`: the same, but there
/// must be one; else those whose label or platform version contains the text, in any case of letters.
/// @throws InvalidInput naming what there is, if what is asked for is not there.
[[nodiscard]] std::vector<DeviceInfo> choose_devices(const std::string& device, const std::vector<DeviceInfo>& all);

}  // namespace patinate::device
