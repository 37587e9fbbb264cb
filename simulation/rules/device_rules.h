/// \file
/// Rules on a device: the kernels of rule_kernel.inl, with the CPU's bytes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "libcommon/device/device.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/device/device_arrays.h"
#include "simulation/rules/compiled_rules.h"
#include "simulation/rules/tile_facts.h"

namespace patinate::simulation {

/// Parameters that are the same at all tiles of a step.
struct RuleStep {
  std::span<const CompiledRule> rules;
  const SignalValues& signals;
  int phase;  ///< Tiles are due whose number modulo RuleEngine::kEpoch it is.
  std::int64_t iteration;
};

/// State that rules keep on a device: which tiles are due when, parameters, which texels are covered, and the drivers'
/// steps.
class DeviceRules {
 public:
  /// Whether a texel's values have room on a device: materials, parameters, and what the longest driver works with are
  /// at most 64.
  [[nodiscard]] static bool can_run(const CompiledRules& rules, std::size_t num_parameters);
  /// @throws DeviceError, as age().
  DeviceRules(const device::Device& device, const CompiledRules& rules, std::span<const SurfaceParameter> parameters,
              const TileFacts& facts);
  ~DeviceRules();
  /// Ages the tiles that are due and awake. Forms of the rules change with time, steps do not.
  void age(const RuleStep& step, DeviceArrays& arrays);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace patinate::simulation
