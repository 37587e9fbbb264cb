/// \file
/// The device that a simulation runs on, as far as it does.
#pragma once

#include "libcommon/device/fallible_device.h"

namespace patinate::simulation {

class SimulationDevice : public device::FallibleDevice {
 public:
  using FallibleDevice::FallibleDevice;
};

}  // namespace patinate::simulation
