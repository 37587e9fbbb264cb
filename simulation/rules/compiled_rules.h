/// \file
/// A scene's rules as kernels take them, with their drivers as lists of steps.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "libcommon/core/expression_program.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/weather.h"
#include "simulation/rules/rule_kernel.h"
#include "simulation/rules/surface_parameter.h"

namespace patinate::simulation {

/// The scene's age, then the weather.
inline constexpr std::size_t kNumSignals = 1 + kNumWeatherSignals;
using SignalValues = std::array<float, kNumSignals>;

/// A rule as the kernel takes it, and its driver's program.
struct CompiledRule {
  KernelRule form{};
  double rate = 0.0;
  ExpressionProgram driver;
  /// A bit for each material slot: without any of that material nothing happens, whatever else there is.
  std::uint32_t needs = 0;
};

/// All rules, and which slot is whose.
struct CompiledRules {
  std::vector<CompiledRule> rules;
  std::vector<int>
      materials;  ///< Those that occur in a rule: slots 0, 1, ... Slots of the parameters follow, then the signals.
  int num_slots = 0;
  std::array<bool, kNumSignals> uses{};  ///< Signals that a driver asks for.

  [[nodiscard]] int slot_of_material(int material) const;
};

/// @param names  Of materials. @throws InvalidInput for a driver that cannot be read or asks for what is not there.
[[nodiscard]] CompiledRules compile_rules(std::span<const Rule> all, std::span<const std::string> names,
                                          std::span<const SurfaceParameter> parameters);

}  // namespace patinate::simulation
