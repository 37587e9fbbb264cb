#include "app/device/checked_devices.h"

#include <mutex>
#include <optional>

#include "libcommon/core/text.h"
#include "simulation/engine/iteration_check.h"

namespace patinate::app {

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
                                           const Words& say) {
  if (options.device == "cpu") return std::nullopt;
  std::string problem;
  for (const device::DeviceInfo& info : device::choose_devices(options.device, device::list_devices())) {
    try {
      device::Device opened(info);
      problem = problem_of(opened, check_kernels);
      if (problem.empty()) {
        say.detail("device: " + device::label(info));
        say.decided("device", device::label(info));
        return opened;
      }
    } catch (const device::DeviceError& error) {
      problem = error.what();
      if (!error.detail().empty()) say.detail(error.detail());
    }
    say.detail(problem);
  }
  if (options.device != "auto") throw CannotComplete(problem + "; use --device cpu");
  say.decided("device", "cpu");
  return std::nullopt;
}

/// Text about the device's work between two times.
std::string text_of(const device::DeviceTimes& before, const device::DeviceTimes& after) {
  const std::uint64_t megabytes = (after.copied_bytes - before.copied_bytes) >> 20;
  return "device: " + short_number_text(rounded(after.kernels_s - before.kernels_s, 3)) + " s in kernels, " +
         short_number_text(rounded(after.copies_s - before.copies_s, 3)) + " s copying " + std::to_string(megabytes) +
         " MB";
}

/// A Kind of device, which says by a note when it fails.
template <class Kind>
std::shared_ptr<const Kind> open_kind(const device::DeviceOptions& options, const KernelCheck& check_kernels,
                                      const Words& say) {
  if (say.is_dry_run) {
    check_device(options);
    return nullptr;
  }
  const std::optional<device::Device> opened = open_checked(options, check_kernels, say);
  if (!opened) return nullptr;
  const auto* kind = new Kind(*opened, [say](const device::DeviceError& error) {
    say.warning(std::string(error.what()) + "; continues on the CPU");
    if (!error.detail().empty()) say.detail(error.detail());
  });
  return std::shared_ptr<const Kind>(kind, [say, before = opened->times()](const Kind* used) {
    say.detail(text_of(before, used->device().times()));
    delete used;
  });
}

}  // namespace

void check_device(const device::DeviceOptions& options) {
  if (options.device != "auto" && options.device != "cpu")
    (void)device::choose_devices(options.device, device::list_devices());
}

std::shared_ptr<const transfer::SearchDevice> open_search_device(const device::DeviceOptions& options,
                                                                 const Words& say) {
  return open_kind<transfer::SearchDevice>(options, transfer::check_search, say);
}

std::shared_ptr<const simulation::SimulationDevice> open_simulation_device(const device::DeviceOptions& options,
                                                                           const Words& say) {
  return open_kind<simulation::SimulationDevice>(options, simulation::check_iterations, say);
}

namespace {

/// Result of `open`, which is called once.
template <class Kind, class Open>
std::function<std::shared_ptr<const Kind>()> once(const Open& open) {
  struct Opened {
    std::mutex mutex;
    bool is_tried = false;
    std::shared_ptr<const Kind> kind;
  };
  return [open, opened = std::make_shared<Opened>()] {
    const std::lock_guard lock(opened->mutex);
    if (!opened->is_tried) opened->kind = open();
    opened->is_tried = true;
    return opened->kind;
  };
}

}  // namespace

OutputDevices output_devices(const device::DeviceOptions& options, const Words& say) {
  check_device(options);
  return {.composition = once<simulation::SimulationDevice>([=] { return open_simulation_device(options, say); })};
}

}  // namespace patinate::app
