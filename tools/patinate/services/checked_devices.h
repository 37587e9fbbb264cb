/// \file
/// The device that a command runs on.
#pragma once

#include <memory>

#include "libcommon/device/device_choice.h"
#include "simulation/device/simulation_device.h"
#include "tools/patinate/command_line/command_run.h"
#include "transfer/lookup/lookup_device.h"
#include "transfer/synthesis/search_device.h"

namespace patinate::cli {

/// The first device that is asked for and gives the CPU's bytes; null where the CPU does the work: with `auto` all but
/// the fast transfer. With --verbose says which it is, and why others are not taken. What fails later is said by `run`,
/// which must outlive it.
/// @throws InvalidInput if what is asked for is not there; CannotComplete if what is asked for by name fails its check.
[[nodiscard]] std::shared_ptr<const transfer::SearchDevice> open_search_device(const device::DeviceOptions& options,
                                                                               CommandRun& run);
/// For the exact search, of the reference method and of audits.
[[nodiscard]] std::shared_ptr<const transfer::SearchDevice> open_window_device(const device::DeviceOptions& options,
                                                                               CommandRun& run);
[[nodiscard]] std::shared_ptr<const transfer::LookupDevice> open_lookup_device(const device::DeviceOptions& options,
                                                                               CommandRun& run);
[[nodiscard]] std::shared_ptr<const simulation::SimulationDevice> open_simulation_device(
    const device::DeviceOptions& options, CommandRun& run);

}  // namespace patinate::cli
