#include "simulation/device/simulation_device.h"

#include <utility>

namespace patinate::simulation {

SimulationDevice::SimulationDevice(const device::Device& device,
                                   std::function<void(const device::DeviceError&)> on_failure)
    : device_(device), on_failure_(std::move(on_failure)) {}

void SimulationDevice::report_failure(const device::DeviceError& error) const {
  if (!has_failed_.exchange(true) && on_failure_) on_failure_(error);
}

}  // namespace patinate::simulation
