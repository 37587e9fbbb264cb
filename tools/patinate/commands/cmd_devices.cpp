#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <thread>

#include "libcommon/core/instruction_set.h"
#include "libcommon/core/text.h"
#include "libcommon/device/device_choice.h"
#include "simulation/engine/iteration_check.h"
#include "simulation/tracing/device_rays.h"
#include "tools/patinate/commands/commands.h"
#include "transfer/synthesis/search_device.h"

namespace patinate::cli {

namespace {

/// "passed", "differs in 3 of 4096", or why it could not be run.
template <class Check>
std::string outcome_of(const Check& check) {
  try {
    const device::CheckResult result = check();
    if (result.is_passed()) return "passed";
    return "differs in " + std::to_string(result.num_different) + " of " + std::to_string(result.num_items);
  } catch (const device::DeviceError& error) {
    return error.what();
  }
}

struct NamedCheck {
  const char* name;
  device::CheckResult (*check)(const device::Device& device);
};
constexpr std::array<NamedCheck, 4> kChecks{{{"arithmetic", device::check_arithmetic},
                                             {"transfer", transfer::check_search},
                                             {"rays", simulation::check_rays},
                                             {"iterations", simulation::check_iterations}}};
using Outcomes = std::array<std::string, kChecks.size()>;

Outcomes check(const device::DeviceInfo& info) {
  Outcomes outcomes;
  try {
    const device::Device opened(info);
    for (std::size_t i = 0; i < kChecks.size(); ++i) outcomes[i] = outcome_of([&] { return kChecks[i].check(opened); });
  } catch (const device::DeviceError& error) {
    outcomes.fill(error.what());
  }
  return outcomes;
}

std::string device_outcome_text(const device::DeviceInfo& info, const Outcomes& outcomes) {
  std::string text = device::label(info) + "\n  " + (info.is_gpu ? "GPU" : "processor") + ", " +
                     std::to_string(info.num_units) + " units, " +
                     number_text(static_cast<double>(info.memory_bytes >> 20)) + " MB, driver " + info.driver + "\n";
  for (std::size_t i = 0; i < kChecks.size(); ++i)
    text += std::string("  ") + kChecks[i].name + ": " + outcomes[i] + "\n";
  return text;
}

}  // namespace

int cmd_devices(CommandRun& run) {
  run.line.without({"threads", "seed", "force", "dry_run"});
  run.line.example("help devices");
  run.line.example("help devices --json");
  if (!run.parse()) return 0;
  const unsigned num_threads = std::max(1U, std::thread::hardware_concurrency());
  const std::string_view instructions = kInstructionSetNames[static_cast<std::size_t>(instruction_set())];
  std::string text = "The CPU: " + std::to_string(num_threads) + " threads, " + std::string(instructions) + "\n";
  Json devices = Json::array();
  const std::vector<device::DeviceInfo> all = device::list_devices();
  for (const device::DeviceInfo& info : all) {
    const Outcomes outcomes = check(info);
    text += device_outcome_text(info, outcomes);
    Json checks = Json::object();
    for (std::size_t i = 0; i < kChecks.size(); ++i) checks[kChecks[i].name] = outcomes[i];
    devices.push_back({{"name", info.name},
                       {"platform", info.platform},
                       {"driver", info.driver},
                       {"is_gpu", info.is_gpu},
                       {"units", info.num_units},
                       {"memory_bytes", info.memory_bytes},
                       {"checks", checks}});
  }
  if (all.empty()) text += "No OpenCL devices: no driver is installed (for NVIDIA, AMD, Intel or PoCL)\n";
  run.report({{"cpu", {{"threads", num_threads}, {"instructions", instructions}}}, {"devices", devices}}, text);
  return 0;
}

}  // namespace patinate::cli
