/// \file
/// Rules on a device: the kernels of rule_kernel.inl, with the CPU's bytes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "libcommon/device/arithmetic_check.h"
#include "libcommon/device/device.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/device/device_amounts.h"
#include "simulation/rules/compiled_rules.h"
#include "simulation/rules/tile_facts.h"

namespace patinate::simulation {

/// Tiles that are due.
struct DueTiles {
  std::vector<TileIndex> tiles;
  std::vector<std::uint32_t> outcomes;  ///< By tile: bit 0: a rule has an extent; bit 1 + slot: it was changed.
  std::array<std::int64_t, kMaxMaterials> made{};  ///< Mass, by slot.
  std::array<std::int64_t, kMaxMaterials> used{};
};

/// What rules keep on a device: parameters, which texels are covered and what they weigh, and the drivers' steps.
class DeviceRules {
 public:
  /// Whether a texel's values have room on a device: materials, parameters, and what the longest driver works with are
  /// at most 64.
  [[nodiscard]] static bool can_run(const CompiledRules& rules, std::size_t num_parameters);
  /// @throws DeviceError, as age().
  DeviceRules(const device::Device& device, const CompiledRules& rules, std::span<const SurfaceParameter> parameters,
              const TileFacts& facts, const SurfaceAtlas& surface);
  ~DeviceRules();
  /// Applies the rules as they are now, to amounts that are there: forms change with time, steps do not.
  void age(std::span<const CompiledRule> rules, const SignalValues& signals, const DeviceAmounts& amounts,
           DueTiles& due);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A plate aged there and here by rules with every kind of step. @throws DeviceError if the device cannot run it.
[[nodiscard]] device::CheckResult check_rules(const device::Device& device);

}  // namespace patinate::simulation
