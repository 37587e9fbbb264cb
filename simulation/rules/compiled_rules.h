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
#include "simulation/rules/layer_values.h"
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
  int target = 0;                   ///< Index into CompiledRules::targets.
  bool acts_on_layer = false;       ///< Nothing happens where its layer is not.
  std::vector<std::size_t> values;  ///< Of CompiledRules::layer_values, that its driver asks for.
  std::vector<std::size_t> states;  ///< Of CompiledRules::layer_states, that it changes.

  [[nodiscard]] bool has_layers() const { return acts_on_layer || !values.empty(); }
};

/// What rules may change of a layer.
enum class LayerStateKind {
  Wear,       ///< kMaxQuanta less the thickness: making it ends where the layer does.
  Loosening,  ///< The same of the adhesion.
  Stress,     ///< As it is.
  Interface   ///< Amounts below it.
};
struct LayerState {
  LayerStateKind kind = LayerStateKind::Wear;
  int material = -1;  ///< Of an interface.
  friend bool operator==(const LayerState&, const LayerState&) = default;
};

/// What rules need to know of a scene's layers.
struct LayerNames {
  std::vector<std::string> names;                ///< layer_names(). Empty: the scene has no layers.
  std::array<bool, kMaxMaterials> is_part_of{};  ///< By material: some layer is made of it.
};

/// All rules, and which slot is whose.
struct CompiledRules {
  std::vector<CompiledRule> rules;
  std::vector<int> materials;  ///< Those that occur in a rule: slots 0, 1, ... Slots of the layers' states follow, then
                               ///< of the parameters, then the signals, then the layers' values.
  std::vector<LayerState> layer_states;  ///< With the interfaces that drivers alone ask for.
  std::vector<LayerValue> layer_values;
  std::vector<std::string> targets{""};  ///< Names of layers that rules act on; "": the outermost.
  int first_layer_value = 0;             ///< Slot.
  int num_slots = 0;
  std::array<bool, kNumSignals> uses{};  ///< Signals that a driver asks for.

  [[nodiscard]] int slot_of_material(int material) const;
  /// Slots of what rules change: materials, then the layers' states.
  [[nodiscard]] std::size_t num_changing() const { return materials.size() + layer_states.size(); }
  [[nodiscard]] bool has_layers() const;
};

/// @param names  Of materials. @throws InvalidInput for a driver that cannot be read or asks for what is not there; for
/// more terms than a rule may have.
[[nodiscard]] CompiledRules compile_rules(std::span<const Rule> all, std::span<const std::string> names,
                                          std::span<const SurfaceParameter> parameters, const LayerNames& layers = {});

}  // namespace patinate::simulation
