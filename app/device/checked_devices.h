/// \file
/// The device that work runs on.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/request/words.h"
#include "libcommon/device/device_choice.h"
#include "simulation/device/simulation_device.h"
#include "transfer/synthesis/search_device.h"

namespace patinate::app {

/// Without opening it. @throws InvalidInput if what is asked for is not there.
void check_device(const device::DeviceOptions& options);

/// The first device that is asked for and gives the CPU's bytes; null where the CPU does the work. Says which it is,
/// why others are not taken, and what fails later.
/// @throws InvalidInput if what is asked for is not there; CannotComplete if what is asked for by name fails its check.
[[nodiscard]] std::shared_ptr<const transfer::SearchDevice> open_search_device(const device::DeviceOptions& options,
                                                                               const Words& say);
[[nodiscard]] std::shared_ptr<const simulation::SimulationDevice> open_simulation_device(
    const device::DeviceOptions& options, const Words& say);

/// The device for what makes pictures and models of simulations, opened when it is first needed, if ever. A null
/// function, and what it gives where nothing is asked for: the CPU.
struct OutputDevices {
  std::function<std::shared_ptr<const simulation::SimulationDevice>()> composition = {};

  /// Null: the CPU does it. @throws as the function.
  [[nodiscard]] std::shared_ptr<const simulation::SimulationDevice> compose() const {
    return composition ? composition() : nullptr;
  }
};
/// It is opened once, whoever asks. Thread-safe. @throws InvalidInput as check_device(); the function as
/// open_simulation_device().
[[nodiscard]] OutputDevices output_devices(const device::DeviceOptions& options, const Words& say);

}  // namespace patinate::app
