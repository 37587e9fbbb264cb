#include "tools/patinate/services/search_devices.h"

namespace patinate::cli {

namespace {

/// Why a device is not taken; empty if it is.
std::string problem_of(const device::Device& opened) {
  const device::CheckResult arithmetic = device::check_arithmetic(opened);
  const device::CheckResult check = arithmetic.is_passed() ? transfer::check_search(opened) : arithmetic;
  if (check.is_passed()) return {};
  return opened.info().name + ": differs from the CPU in " + std::to_string(check.num_different) + " of " +
         std::to_string(check.num_items) + (arithmetic.is_passed() ? " places" : " calculations") +
         ", so it is not used";
}

}  // namespace

std::shared_ptr<const transfer::SearchDevice> open_search_device(const device::DeviceOptions& options,
                                                                 CommandRun& run) {
  if (options.device == "cpu") return nullptr;
  const std::vector<device::DeviceInfo> candidates = device::choose_devices(options.device, device::list_devices());
  std::string problem;
  for (const device::DeviceInfo& info : candidates) {
    try {
      const device::Device opened(info);
      problem = problem_of(opened);
      if (problem.empty()) {
        run.detail("device: " + device::label(info));
        run.line.decided("device", device::label(info));
        return std::make_shared<const transfer::SearchDevice>(opened,
                                                              [&run](const std::string& text) { run.note(text); });
      }
    } catch (const device::DeviceError& error) {
      problem = error.what();
      if (!error.detail().empty()) run.detail(error.detail());
    }
    run.detail(problem);
  }
  if (options.device != "auto") throw CannotComplete(problem + "; --device cpu does without");
  run.line.decided("device", "cpu");
  return nullptr;
}

}  // namespace patinate::cli
