/// \file
/// Whole iterations on a device.
#pragma once

#include <cstdint>

#include "simulation/device/device_amounts.h"
#include "simulation/device/device_arrays.h"
#include "simulation/tracing/motion_facts.h"
#include "simulation/transport/device_exchange.h"
#include "simulation/transport/trail.h"

namespace patinate::simulation {

/// State that the engine keeps on a device. It is the engine's, or some iterations ahead of it, until somebody
/// asks: it then comes back.
struct DeviceRun {
  /// @throws DeviceError
  DeviceRun(const device::Device& device, const SurfaceAtlas& surface, int num_materials, std::size_t num_gammatons,
            const ParameterMapChoice& maps)
      : arrays(device, surface, num_materials, num_gammatons), exchange(arrays, surface, maps), amounts(device) {
    arrays.drops = device.allocate<DropRecord>(num_gammatons);
    arrays.trails = device.allocate<Trail>(num_gammatons);
  }

  DeviceArrays arrays;
  DeviceExchange exchange;
  DeviceAmounts amounts;
  std::int64_t known_at = 0;  ///< The iteration up to which the engine has the state.
  bool is_ahead = false;      ///< The device has done iterations since.
  bool is_stale = true;       ///< The engine has changed something since.
  bool has_amounts = false;   ///< But for tiles that have changed in the engine in known_at or later.
};

}  // namespace patinate::simulation
