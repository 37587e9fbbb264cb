#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "libcommon/core/instruction_set.h"
#include "libcommon/core/text.h"
#include "libcommon/device/device_choice.h"
#include "simulation/composition/compose_device.h"
#include "simulation/rules/device_rules.h"
#include "simulation/tracing/device_motion.h"
#include "simulation/tracing/device_rays.h"
#include "tools/patinate/commands/commands.h"
#include "transfer/lookup/lookup_device.h"
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

struct Outcome {
  std::string arithmetic, transfer, lookups, composition, rules, rays, motion;
};

Outcome check(const device::DeviceInfo& info) {
  try {
    const device::Device opened(info);
    return {outcome_of([&] { return device::check_arithmetic(opened); }),
            outcome_of([&] { return transfer::check_search(opened); }),
            outcome_of([&] { return transfer::check_lookups(opened); }),
            outcome_of([&] { return simulation::check_composition(opened); }),
            outcome_of([&] { return simulation::check_rules(opened); }),
            outcome_of([&] { return simulation::check_rays(opened); }),
            outcome_of([&] { return simulation::check_motion(opened); })};
  } catch (const device::DeviceError& error) {
    const std::string what = error.what();
    return {what, what, what, what, what, what, what};
  }
}

std::string text_of(const device::DeviceInfo& info, const Outcome& outcome) {
  return device::label(info) + "\n  " + (info.is_gpu ? "GPU" : "processor") + ", " + std::to_string(info.num_units) +
         " units, " + number_text(static_cast<double>(info.memory_bytes >> 20)) + " MB, driver " + info.driver +
         "\n  arithmetic: " + outcome.arithmetic + "\n  transfer: " + outcome.transfer +
         "\n  lookups: " + outcome.lookups + "\n  composition: " + outcome.composition + "\n  rules: " + outcome.rules +
         "\n  rays: " + outcome.rays + "\n  gammatons: " + outcome.motion + "\n";
}

}  // namespace

int cmd_devices(CommandRun& run) {
  run.line.without({"threads", "seed", "force", "dry_run"});
  run.line.example("devices");
  run.line.example("devices --json");
  if (!run.parse()) return 0;
  const unsigned num_threads = std::max(1U, std::thread::hardware_concurrency());
  const std::string_view instructions = kInstructionSetNames[static_cast<std::size_t>(instruction_set())];
  std::string text = "The CPU: " + std::to_string(num_threads) + " threads, " + std::string(instructions) + "\n";
  Json devices = Json::array();
  const std::vector<device::DeviceInfo> all = device::list_devices();
  for (const device::DeviceInfo& info : all) {
    const Outcome outcome = check(info);
    text += text_of(info, outcome);
    devices.push_back({{"name", info.name},
                       {"platform", info.platform},
                       {"driver", info.driver},
                       {"is_gpu", info.is_gpu},
                       {"units", info.num_units},
                       {"memory_bytes", info.memory_bytes},
                       {"checks",
                        {{"arithmetic", outcome.arithmetic},
                         {"transfer", outcome.transfer},
                         {"lookups", outcome.lookups},
                         {"composition", outcome.composition},
                         {"rules", outcome.rules},
                         {"rays", outcome.rays},
                         {"gammatons", outcome.motion}}}});
  }
  if (all.empty()) text += "No OpenCL devices: no driver is installed (for NVIDIA, AMD, Intel or PoCL)\n";
  run.report({{"cpu", {{"threads", num_threads}, {"instructions", instructions}}}, {"devices", devices}}, text);
  return 0;
}

}  // namespace patinate::cli
