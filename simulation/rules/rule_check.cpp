#include <memory>
#include <optional>
#include <utility>

#include "libcommon/core/random.h"
#include "simulation/device/check_scene.h"
#include "simulation/device/simulation_device.h"
#include "simulation/rules/device_rules.h"
#include "simulation/rules/rules.h"

namespace patinate::simulation {

namespace {

/// Every step of expressions, makes and uses, rules that run dry and that overflow.
std::vector<Rule> check_rules_of_all_kinds() {
  std::vector<Rule> rules(4);
  rules[0] = {.name = "one",
              .driver = "pow(material0, 0.7) * clamp(material1 - 0.2, 0, 0.5) + smoothstep(0.1, 0.6, bytes)",
              .rate = 0.05,
              .products = {0.0, 0.4, 1.0},
              .reactants = {1.0}};
  rules[1] = {.name = "two",
              .driver = "min(material0, material1, 0.4) / max(material2, words) + abs(floats - age)",
              .rate = 0.2,
              .products = {3.0},
              .reactants = {0.0, 0.5, 0.25}};
  rules[2] = {.name = "three", .driver = "!material1 - rain", .rate = 0.3, .products = {0.0, 0.1}, .where = "words"};
  rules[3] = {.name = "four", .driver = "-(-material2)", .rate = 4.0, .reactants = {0.0, 0.0, 1.0}};
  return rules;
}

/// One of each form.
std::vector<SurfaceParameter> check_parameters(std::uint32_t num_texels) {
  std::vector<std::uint8_t> bytes(num_texels);
  std::vector<std::uint16_t> words(num_texels);
  std::vector<float> floats(num_texels);
  for (std::uint32_t t = 0; t < num_texels; ++t) {
    RandomStream random(4, t);
    bytes[t] = static_cast<std::uint8_t>(random.below(256));
    words[t] = static_cast<std::uint16_t>(random.below(65536));
    floats[t] = static_cast<float>(random.uniform());
  }
  return {{.name = "bytes", .values = std::move(bytes), .low = -0.5F},
          {.name = "words", .values = std::move(words)},
          {.name = "floats", .values = std::move(floats)}};
}

}  // namespace

device::CheckResult check_rules(const device::Device& device) {
  constexpr int kIterations = 2 * RuleEngine::kEpoch;
  const Scene scene = check_scene();
  const CheckSurface on(scene);
  std::optional<device::DeviceError> failure;
  const auto make_engine = [&] {
    return RuleEngine(check_rules_of_all_kinds(), scene.materials, on.surface, 0.1, 7,
                      check_parameters(on.surface.grid().num_texels()));
  };
  RuleEngine here = make_engine(), there = make_engine();
  there.use(
      std::make_shared<const SimulationDevice>(device, [&](const device::DeviceError& problem) { failure = problem; }));
  MaterialAtlas expected = on.any_amounts(), found = on.any_amounts();
  device::CheckResult check{.num_items = std::int64_t{on.num_materials} * on.surface.grid().num_texels()};
  for (int i = 0; i < kIterations; ++i) {
    const RuleReport a = here.step(i, expected), b = there.step(i, found);
    check.num_different += a.made == b.made && a.used == b.used ? 0 : 1;
  }
  if (failure) throw device::DeviceError(*failure);
  for (int m = 0; m < on.num_materials; ++m) {
    for (TexelIndex t = 0; t < on.surface.grid().num_texels(); ++t)
      check.num_different += expected.amount(m, t) == found.amount(m, t) ? 0 : 1;
  }
  return check;
}

}  // namespace patinate::simulation
