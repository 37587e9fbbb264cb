/// \file
/// Rays on a device: the kernel of ray_kernel.inl, with the CPU's bytes. Gammatons are still traced by the CPU: hits
/// alone do not pay, as long as flight between them is not on the device too.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "libcommon/device/arithmetic_check.h"
#include "libcommon/device/device.h"
#include "simulation/tracing/ray_tracer.h"

namespace patinate::simulation {

/// The texts of ray_types.inl, four_lanes.inl, ray_kernel.inl and ray_device.cl.
extern const std::string_view kRayTypes, kRayLanes, kRayKernel, kRayEntries;

using ray_types::RayAnswer;
using ray_types::RayQuery;

/// A scene's hierarchy on a device.
class DeviceRays {
 public:
  /// @throws DeviceError, as all members.
  DeviceRays(const device::Device& device, const RayTracer& rays);
  ~DeviceRays();
  /// RayTracer::first_hit() of each.
  [[nodiscard]] std::vector<RayAnswer> first_hits(std::span<const RayQuery> queries);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Rays of all kinds through a rough surface, there and here. @throws DeviceError if the device cannot run it.
[[nodiscard]] device::CheckResult check_rays(const device::Device& device);

}  // namespace patinate::simulation
