#include "simulation/rules/device_rules.h"

#include <algorithm>
#include <cstring>
#include <variant>

#include "libcommon/core/expression_kernel.h"
#include "libcommon/core/portable_math.h"
#include "simulation/rules/rules.h"

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
  const std::array<std::string_view, 8> sources{kPortableMath, kExpressionKernel, kExpressionPower, kRuleTypes,
                                                kRuleKernel,   kTallyTypes,       kTallyKernel,     kRuleEntries};
  return device.build("rules", sources);
}

}  // namespace

bool DeviceRules::can_run(const CompiledRules& rules, std::size_t num_parameters) {
  return PackedDrivers(rules, num_parameters).num_own <= kFirstShared;
}

struct DeviceRules::State {
  State(const device::Device& its_device, const CompiledRules& compiled, std::span<const SurfaceParameter> parameters,
        const TileFacts& facts)
      : device(its_device),
        drivers(compiled, parameters.size()),
        num_slots(static_cast<std::int32_t>(compiled.materials.size())),
        never_sleeps(compiled.uses[0] ? 1 : 0),
        age(build(device).kernel("age_due")),
        steps(upload_some(device, std::span<const DriverStep>(drivers.steps))),
        codes(upload_some(device, std::span<const std::uint8_t>(packed_parameters(parameters, parameter_codes)))),
        parameters_at(upload_some(device, std::span<const ParameterCodes>(parameter_codes))),
        materials(upload_some(device, std::span<const std::uint32_t>(std::vector<std::uint32_t>(
                                          compiled.materials.begin(), compiled.materials.end())))),
        rules(device.allocate<PackedRule>(drivers.rules.size())),
        everywhere(device.allocate<float>(kNumSignals + drivers.constants.size())),
        covered(device.upload(facts.covered_texels())) {
    std::array<std::vector<TileIndex>, RuleEngine::kEpoch> by_phase;
    const std::span<const std::uint64_t> texels = facts.covered_texels();
    for (TileIndex t = 0; t < texels.size(); ++t) {
      if (texels[t] != 0) by_phase[t % RuleEngine::kEpoch].push_back(t);
    }
    for (std::size_t phase = 0; phase < due.size(); ++phase) {
      num_due[phase] = by_phase[phase].size();
      due[phase] = upload_some(device, std::span<const TileIndex>(by_phase[phase]));
    }
  }

  device::Device device;
  PackedDrivers drivers;
  std::int32_t num_slots, never_sleeps;
  device::Kernel age;
  std::vector<ParameterCodes> parameter_codes;
  Buffer<DriverStep> steps;
  Buffer<std::uint8_t> codes;
  Buffer<ParameterCodes> parameters_at;
  Buffer<std::uint32_t> materials;  ///< By slot.
  Buffer<PackedRule> rules;
  std::vector<float> known_everywhere;  ///< Values on the device.
  Buffer<float> everywhere;
  Buffer<std::uint64_t> covered;
  std::array<Buffer<TileIndex>, RuleEngine::kEpoch> due;  ///< By phase: covered tiles.
  std::array<std::size_t, RuleEngine::kEpoch> num_due{};
};

DeviceRules::DeviceRules(const device::Device& device, const CompiledRules& rules,
                         std::span<const SurfaceParameter> parameters, const TileFacts& facts)
    : state_(std::make_unique<State>(device, rules, parameters, facts)) {}
DeviceRules::~DeviceRules() = default;

void DeviceRules::age(const RuleStep& step, DeviceArrays& a) {
  State& s = *state_;
  const auto phase = static_cast<std::size_t>(step.phase);
  if (s.num_due[phase] == 0) return;
  for (std::size_t r = 0; r < step.rules.size(); ++r) s.drivers.rules[r].form = step.rules[r].form;
  s.device.write_soon(std::span<const PackedRule>(s.drivers.rules), s.rules);
  std::vector<float> everywhere(step.signals.begin(), step.signals.end());
  everywhere.insert(everywhere.end(), s.drivers.constants.begin(), s.drivers.constants.end());
  // Bit for bit: a signal may be no number.
  if (s.known_everywhere.size() != everywhere.size() ||
      std::memcmp(s.known_everywhere.data(), everywhere.data(), everywhere.size() * sizeof(float)) != 0) {
    s.device.write_soon(std::span<const float>(everywhere), s.everywhere);
    s.known_everywhere = std::move(everywhere);
  }
  // Tiles of one launch, which stays short.
  constexpr std::size_t kBatch = std::size_t{1} << 16;
  for (std::size_t first = 0; first < s.num_due[phase]; first += kBatch) {
    const std::size_t num = std::min(kBatch, s.num_due[phase] - first);
    s.age.run(
        {.first = first * TileGrid::kTileTexels, .num = num * TileGrid::kTileTexels, .group = TileGrid::kTileTexels},
        s.due[phase], s.rules, static_cast<std::int32_t>(step.rules.size()), s.steps, s.everywhere, s.parameters_at,
        static_cast<std::int32_t>(s.parameter_codes.size()), s.codes, s.covered, a.weights, s.num_slots, s.materials,
        a.num_texels, s.never_sleeps, static_cast<std::int32_t>(step.iteration), a.amounts, a.dirty, a.changed_in,
        a.awake, a.is_listed, a.touched, a.tally);
  }
}

}  // namespace patinate::simulation
