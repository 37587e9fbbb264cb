#include "tools/patinate/services/checked_devices.h"

#include <functional>
#include <optional>

#include "libcommon/core/text.h"
#include "simulation/composition/compose_device.h"
#include "simulation/rules/device_rules.h"
#include "simulation/tracing/device_motion.h"
#include "simulation/transport/device_exchange.h"
#include "transfer/synthesis/window_device.h"

namespace patinate::cli {

namespace {

using KernelCheck = std::function<device::CheckResult(const device::Device&)>;

/// Why a device is not taken; empty if it is.
std::string problem_of(const device::Device& opened, const KernelCheck& check_kernels) {
  const device::CheckResult arithmetic = device::check_arithmetic(opened);
  const device::CheckResult check = arithmetic.is_passed() ? check_kernels(opened) : arithmetic;
  if (check.is_passed()) return {};
  return opened.info().name + ": differs from the CPU in " + std::to_string(check.num_different) + " of " +
         std::to_string(check.num_items) + (arithmetic.is_passed() ? " values" : " calculations") +
         ", so it is not used";
}

std::optional<device::Device> open_checked(const device::DeviceOptions& options, const KernelCheck& check_kernels,
                                           CommandRun& run) {
  if (options.device == "cpu") return std::nullopt;
  std::string problem;
  if (run.line.common().dry_run) {
    (void)device::choose_devices(options.device, device::list_devices());
    return std::nullopt;
  }
  for (const device::DeviceInfo& info : device::choose_devices(options.device, device::list_devices())) {
    try {
      device::Device opened(info);
      problem = problem_of(opened, check_kernels);
      if (problem.empty()) {
        run.detail("device: " + device::label(info));
        run.line.decided("device", device::label(info));
        return opened;
      }
    } catch (const device::DeviceError& error) {
      problem = error.what();
      if (!error.detail().empty()) run.detail(error.detail());
    }
    run.detail(problem);
  }
  if (options.device != "auto") throw CannotComplete(problem + "; --device cpu does without");
  run.line.decided("device", "cpu");
  return std::nullopt;
}

/// What the device did between two times.
std::string text_of(const device::DeviceTimes& before, const device::DeviceTimes& after) {
  const std::uint64_t megabytes = (after.copied_bytes - before.copied_bytes) >> 20;
  return "device: " + short_number_text(rounded(after.kernels_s - before.kernels_s, 3)) + " s in kernels, " +
         short_number_text(rounded(after.copies_s - before.copies_s, 3)) + " s copying " + std::to_string(megabytes) +
         " MB";
}

/// A Kind of device, which says by a note when it fails.
template <class Kind>
std::shared_ptr<const Kind> open_kind(const device::DeviceOptions& options, const KernelCheck& check_kernels,
                                      CommandRun& run) {
  const std::optional<device::Device> opened = open_checked(options, check_kernels, run);
  if (!opened) return nullptr;
  const auto* kind = new Kind(*opened, [&run](const device::DeviceError& error) {
    run.note(std::string(error.what()) + "; goes on without it");
    if (!error.detail().empty()) run.detail(error.detail());
  });
  return std::shared_ptr<const Kind>(kind, [&run, before = opened->times()](const Kind* used) {
    run.detail(text_of(before, used->device().times()));
    delete used;
  });
}

/// For what is mostly copying: on the fastest cards, too, the ways there and back take longer than the CPU's own work
/// (docs/devices.md); and for what was not measured on a GPU. A device is taken only where it is asked for.
device::DeviceOptions if_asked_for(const device::DeviceOptions& options, CommandRun& run) {
  if (options.device != "auto") return options;
  run.line.decided("device", "cpu");
  return {.device = "cpu"};
}

}  // namespace

std::shared_ptr<const transfer::SearchDevice> open_search_device(const device::DeviceOptions& options,
                                                                 CommandRun& run) {
  return open_kind<transfer::SearchDevice>(options, transfer::check_search, run);
}

std::shared_ptr<const transfer::SearchDevice> open_window_device(const device::DeviceOptions& options,
                                                                 CommandRun& run) {
  return open_kind<transfer::SearchDevice>(if_asked_for(options, run), transfer::check_window_search, run);
}

std::shared_ptr<const transfer::LookupDevice> open_lookup_device(const device::DeviceOptions& options,
                                                                 CommandRun& run) {
  return open_kind<transfer::LookupDevice>(if_asked_for(options, run), transfer::check_lookups, run);
}

std::shared_ptr<const simulation::SimulationDevice> open_simulation_device(const device::DeviceOptions& options,
                                                                           CommandRun& run) {
  const auto check_all = [](const device::Device& opened) {
    device::CheckResult result;
    for (const auto check : {simulation::check_composition, simulation::check_rules, simulation::check_exchange,
                             simulation::check_motion}) {
      result = check(opened);
      if (!result.is_passed()) break;
    }
    return result;
  };
  return open_kind<simulation::SimulationDevice>(if_asked_for(options, run), check_all, run);
}

}  // namespace patinate::cli
