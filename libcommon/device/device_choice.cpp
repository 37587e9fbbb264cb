#include "libcommon/device/device_choice.h"

#include <algorithm>

#include "libcommon/core/file_name.h"

namespace patinate::device {

void describe(OptionVisitor& v, DeviceOptions& o) {
  v.visit(
      {"device",
       "Device for calculations: auto, cpu, gpu, or part of a name from `patinate help devices`; auto uses a GPU for "
       "fast transfers and simulations if it gives the same bytes as the CPU; results do not depend on the device"},
      o.device);
}

std::string label(const DeviceInfo& info) { return info.name + " (" + info.platform + ")"; }

namespace {

std::string names_of(const std::vector<DeviceInfo>& all) {
  std::string names;
  for (const DeviceInfo& info : all) names += (names.empty() ? "" : ", ") + label(info);
  return names.empty() ? "OpenCL has no devices here" : "there is " + names;
}

}  // namespace

std::vector<DeviceInfo> choose_devices(const std::string& device, const std::vector<DeviceInfo>& all) {
  if (device == "cpu") return {};
  const bool is_any = device == "auto" || device == "gpu";
  std::vector<DeviceInfo> chosen;
  for (const DeviceInfo& info : all) {
    const bool is_meant =
        is_any ? info.is_gpu
               : lower_case(label(info) + " " + info.version).find(lower_case(device)) != std::string::npos;
    if (is_meant) chosen.push_back(info);
  }
  std::stable_sort(chosen.begin(), chosen.end(), [](const DeviceInfo& a, const DeviceInfo& b) {
    return a.memory_bytes > b.memory_bytes;  // Cards before what is part of a processor.
  });
  if (chosen.empty() && device != "auto")
    throw InvalidInput("--device: found `" + device + "`; " + names_of(all) + "; or auto, cpu");
  return chosen;
}

}  // namespace patinate::device
