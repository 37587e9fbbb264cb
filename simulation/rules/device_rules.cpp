#include "simulation/rules/device_rules.h"

#include <algorithm>
#include <cstring>
#include <variant>

#include "libcommon/core/expression_kernel.h"
#include "libcommon/core/portable_math.h"
#include "simulation/device/exact_sums.h"

namespace patinate::simulation {

using device::Buffer;
using rule_types::DriverStep;
using rule_types::kFirstShared;
using rule_types::PackedRule;
using rule_types::ParameterCodes;

namespace {

/// All drivers with their values numbered as a device has them: a texel's own are materials, parameters, and what one
/// driver works with; signals and constants are the same everywhere.
struct PackedDrivers {
  PackedDrivers(const CompiledRules& compiled, std::size_t num_parameters);

  std::vector<PackedRule> rules;  ///< Without their forms.
  std::vector<DriverStep> steps;
  std::vector<float> constants;  ///< Behind the signals.
  std::size_t num_own = 0;

 private:
  [[nodiscard]] std::uint32_t value(int slot, const ExpressionProgram& program, std::vector<int>& working);

  int first_signal_;
};

PackedDrivers::PackedDrivers(const CompiledRules& compiled, std::size_t num_parameters)
    : first_signal_(static_cast<int>(compiled.materials.size() + num_parameters)) {
  num_own = static_cast<std::size_t>(first_signal_);
  for (const CompiledRule& rule : compiled.rules) {
    std::vector<int> working;  // Slots, by their number among a driver's own.
    PackedRule packed{};
    packed.first_step = static_cast<std::int32_t>(steps.size());
    for (const ExpressionStep& step : rule.driver.steps) {
      const auto number = [&](int slot) { return value(slot, rule.driver, working); };
      const std::uint32_t out = number(step.out);
      const auto kind = static_cast<std::uint32_t>(step.kind);
      steps.push_back({.kind = kind, .out = out, .a = number(step.a), .b = number(step.b), .c = number(step.c)});
    }
    packed.end_step = static_cast<std::int32_t>(steps.size());
    packed.result = value(rule.driver.result, rule.driver, working);
    for (int k = 0; k < rule.form.num_terms; ++k) packed.changes |= 1U << rule.form.terms[k].material;
    rules.push_back(packed);
    for (const ExpressionProgram::Constant& constant : rule.driver.constants) constants.push_back(constant.value);
  }
}

std::uint32_t PackedDrivers::value(int slot, const ExpressionProgram& program, std::vector<int>& working) {
  if (slot < first_signal_) return static_cast<std::uint32_t>(slot);
  const auto signal = static_cast<std::size_t>(slot - first_signal_);
  if (signal < kNumSignals) return kFirstShared + static_cast<std::uint32_t>(signal);
  const auto is_slot = [&](const ExpressionProgram::Constant& constant) { return constant.slot == slot; };
  const auto constant = std::find_if(program.constants.begin(), program.constants.end(), is_slot);
  if (constant != program.constants.end()) {
    const std::size_t before = kNumSignals + constants.size();
    return kFirstShared +
           static_cast<std::uint32_t>(before + static_cast<std::size_t>(constant - program.constants.begin()));
  }
  auto found = std::find(working.begin(), working.end(), slot);
  if (found == working.end()) found = working.insert(working.end(), slot);
  num_own = std::max(num_own, static_cast<std::size_t>(first_signal_) + working.size());
  return static_cast<std::uint32_t>(first_signal_ + (found - working.begin()));
}

/// Parameters one behind the other.
std::vector<std::uint8_t> packed_parameters(std::span<const SurfaceParameter> parameters,
                                            std::vector<ParameterCodes>& codes) {
  std::vector<std::uint8_t> bytes;
  for (const SurfaceParameter& parameter : parameters) {
    std::visit(
        [&](const auto& values) {
          const std::size_t each = sizeof(values[0]), first = bytes.size();
          codes.push_back({.first = first,
                           .bytes_each = static_cast<std::int32_t>(each),
                           .low = parameter.low,
                           .step = code_step(parameter)});
          bytes.resize(first + each * values.size());
          std::memcpy(bytes.data() + first, values.data(), each * values.size());
        },
        parameter.values);
  }
  return bytes;
}

device::Program build(const device::Device& device) {
  const std::array<std::string_view, 7> sources{kPortableMath, kExpressionKernel, kExpressionPower, kRuleTypes,
                                                kRuleKernel,   kExactSums,        kRuleEntries};
  return device.build("rules", sources);
}

}  // namespace

bool DeviceRules::can_run(const CompiledRules& rules, std::size_t num_parameters) {
  return PackedDrivers(rules, num_parameters).num_own <= kFirstShared;
}

struct DeviceRules::State {
  State(const device::Device& its_device, const CompiledRules& compiled, std::span<const SurfaceParameter> parameters,
        const TileFacts& facts, const SurfaceAtlas& surface)
      : device(its_device),
        drivers(compiled, parameters.size()),
        num_slots(static_cast<std::int32_t>(compiled.materials.size())),
        age(build(device).kernel("age_tiles")),
        steps(device.upload(drivers.steps)),
        codes(device.upload(packed_parameters(parameters, parameter_codes))),
        parameters_at(device.upload(parameter_codes)),
        materials(device.upload(std::vector<std::uint32_t>(compiled.materials.begin(), compiled.materials.end()))),
        num_texels(surface.grid().num_texels()),
        covered(device.upload(facts.covered_texels())),
        weights(device.upload(surface.weights())) {}

  device::Device device;
  PackedDrivers drivers;
  std::int32_t num_slots;
  device::Kernel age;
  std::vector<ParameterCodes> parameter_codes;
  Buffer<DriverStep> steps;
  Buffer<std::uint8_t> codes;
  Buffer<ParameterCodes> parameters_at;
  Buffer<std::uint32_t> materials;  ///< By slot.
  std::uint32_t num_texels;
  Buffer<std::uint64_t> covered;
  Buffer<std::uint16_t> weights;
};

DeviceRules::DeviceRules(const device::Device& device, const CompiledRules& rules,
                         std::span<const SurfaceParameter> parameters, const TileFacts& facts,
                         const SurfaceAtlas& surface)
    : state_(std::make_unique<State>(device, rules, parameters, facts, surface)) {}
DeviceRules::~DeviceRules() = default;

void DeviceRules::age(std::span<const CompiledRule> rules, const SignalValues& signals, const DeviceAmounts& amounts,
                      DueTiles& due) {
  State& s = *state_;
  const device::Device& d = s.device;
  for (std::size_t r = 0; r < rules.size(); ++r) s.drivers.rules[r].form = rules[r].form;
  std::vector<float> everywhere(signals.begin(), signals.end());
  everywhere.insert(everywhere.end(), s.drivers.constants.begin(), s.drivers.constants.end());
  std::array<std::uint32_t, 4 * kMaxMaterials> words{};
  const auto outcomes = d.allocate<std::uint32_t>(due.tiles.size());
  const auto sums = d.upload(std::span<const std::uint32_t>(words));
  s.age.run({.num = due.tiles.size() * TileGrid::kTileTexels, .group = TileGrid::kTileTexels}, d.upload(due.tiles),
            d.upload(s.drivers.rules), static_cast<std::int32_t>(rules.size()), s.steps, d.upload(everywhere),
            s.parameters_at, static_cast<std::int32_t>(s.parameter_codes.size()), s.codes, s.covered, s.weights,
            s.num_slots, s.materials, s.num_texels, amounts.planes(), outcomes, sums);
  due.outcomes.resize(due.tiles.size());
  d.read(outcomes, std::span(due.outcomes));
  d.read(sums, std::span<std::uint32_t>(words));
  const auto sum_of = [&](std::size_t at) {
    return static_cast<std::int64_t>(words[at] | std::uint64_t{words[at + 1]} << 32);
  };
  for (std::size_t slot = 0; slot < kMaxMaterials; ++slot) {
    due.made[slot] = sum_of(4 * slot);
    due.used[slot] = sum_of(4 * slot + 2);
  }
}

}  // namespace patinate::simulation
