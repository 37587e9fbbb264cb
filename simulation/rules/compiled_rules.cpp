#include "simulation/rules/compiled_rules.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "patinate/core/error.h"
#include "simulation/rules/rules.h"

namespace patinate::simulation {

namespace {

/// The driver, where the rule acts at all. @param maps  Names of maps beyond the built-in ones.
Expression driver_of(const Rule& rule, std::span<const std::string> materials, std::span<const std::string> maps) {
  const std::vector<std::string> names = driver_names(materials, maps);
  const auto parse = [&](const std::string& text, const std::string& part) {
    try {
      return parse_expression(text, {.subject = "rule '" + rule.name + "': " + part,
                                     .name = "material or parameter",
                                     .names = names,
                                     .has_files = false});
    } catch (const ParseError& e) {
      throw InvalidInput(e.what());
    }
  };
  Expression driver = parse(rule.driver, "driver");
  if (rule.where.empty()) return driver;
  (void)parse(rule.where, "where");
  return parse("(" + rule.driver + ") * clamp(" + rule.where + ", 0, 1)", "driver and where");
}

/// Names of a driver that are no materials, those of time or the others.
std::vector<std::string> names_beside(const Rule& rule, std::span<const std::string> materials,
                                      std::span<const std::string> maps, bool is_of_time) {
  std::vector<std::string> out;
  for (const ExpressionName& name : driver_of(rule, materials, maps).names) {
    const bool is_material = std::find(materials.begin(), materials.end(), name.text) != materials.end();
    if (!is_material && is_time_signal(name.text) == is_of_time) out.push_back(name.text);
  }
  return out;
}

std::size_t signal_index(std::string_view name) {
  const std::optional<WeatherSignal> signal = weather_signal_of(name);
  return signal ? 1 + static_cast<std::size_t>(*signal) : 0;
}

/// Known facts of a value: which materials (bits by slot) make it 0 where there is none of them, and whether it is
/// ever negative.
struct Sign {
  std::uint32_t zero_without = 0;
  bool is_never_negative = false;
};

Sign sign_of(ExpressionNode::Kind kind, const Sign& a, const Sign& b) {
  using Kind = ExpressionNode::Kind;
  const bool are_positive = a.is_never_negative && b.is_never_negative;
  switch (kind) {
    case Kind::Multiply:
      return {a.zero_without | b.zero_without, are_positive};
    case Kind::Divide:
      return {a.zero_without | b.zero_without, are_positive};  // by 0 it is 0
    case Kind::Add:
      return {a.zero_without & b.zero_without, are_positive};
    case Kind::Min:
      return {(b.is_never_negative ? a.zero_without : 0) | (a.is_never_negative ? b.zero_without : 0), are_positive};
    case Kind::Max:
      return {a.zero_without & b.zero_without, a.is_never_negative || b.is_never_negative};
    case Kind::Negate:
      return {a.zero_without, false};
    case Kind::Abs:
      return {a.zero_without, true};
    case Kind::Smoothstep:
      return {0, true};
    case Kind::Clamp:  // b: the lower end
      return {0, b.is_never_negative};
    default:
      return {};
  }
}

/// CompiledRule::needs.
std::uint32_t needs_of(const CompiledRule& rule, std::size_t num_materials) {
  std::vector<Sign> slots(static_cast<std::size_t>(rule.driver.num_slots));
  for (std::size_t m = 0; m < num_materials; ++m) slots[m] = {std::uint32_t{1} << m, true};
  for (const auto& constant : rule.driver.constants)
    slots[constant.slot] = {constant.value == 0.0F ? ~std::uint32_t{0} : 0, constant.value >= 0.0F};
  for (const ExpressionStep& step : rule.driver.steps)
    slots[step.out] = sign_of(step.kind, slots[step.a], slots[step.b]);
  std::uint32_t needs = slots[rule.driver.result].zero_without;
  for (int k = rule.form.num_makes; k < rule.form.num_terms; ++k)
    needs |= std::uint32_t{1} << rule.form.terms[k].material;
  return needs & ((std::uint32_t{1} << num_materials) - 1);
}

}  // namespace

std::vector<std::string> parameters_of(const Rule& rule, std::span<const std::string> materials,
                                       std::span<const std::string> maps) {
  return names_beside(rule, materials, maps, false);
}

std::vector<std::string> signals_of(const Rule& rule, std::span<const std::string> materials,
                                    std::span<const std::string> maps) {
  return names_beside(rule, materials, maps, true);
}

int CompiledRules::slot_of_material(int material) const {
  return static_cast<int>(std::find(materials.begin(), materials.end(), material) - materials.begin());
}

CompiledRules compile_rules(std::span<const Rule> all, std::span<const std::string> names,
                            std::span<const SurfaceParameter> parameters) {
  CompiledRules out;
  std::vector<Expression> drivers;
  std::array<bool, kMaxMaterials> occurs{};
  std::vector<std::string> maps;
  for (const SurfaceParameter& parameter : parameters) maps.push_back(parameter.name);
  for (const Rule& rule : all) {
    drivers.push_back(driver_of(rule, names, maps));
    for (const ExpressionName& name : drivers.back().names) {
      const auto m = static_cast<std::size_t>(std::find(names.begin(), names.end(), name.text) - names.begin());
      if (m < names.size()) {
        occurs[m] = true;
      } else if (is_time_signal(name.text)) {
        out.uses[signal_index(name.text)] = true;
      } else if (std::none_of(parameters.begin(), parameters.end(),
                              [&](const SurfaceParameter& p) { return p.name == name.text; })) {
        throw InvalidInput("rule '" + rule.name + "' asks for `" + name.text + "`, of which there is no map here");
      }
    }
    for (std::size_t m = 0; m < names.size(); ++m)
      occurs[m] = occurs[m] || rule.products[m] > 0.0 || rule.reactants[m] > 0.0;
  }
  for (std::size_t m = 0; m < names.size(); ++m) {
    if (occurs[m]) out.materials.push_back(static_cast<int>(m));
  }
  const auto first_signal = static_cast<int>(out.materials.size() + parameters.size());
  const auto slot_of = [&](const ExpressionName& name) {
    const auto m = std::find(names.begin(), names.end(), name.text) - names.begin();
    if (m < static_cast<std::ptrdiff_t>(names.size())) return out.slot_of_material(static_cast<int>(m));
    if (is_time_signal(name.text)) return first_signal + static_cast<int>(signal_index(name.text));
    const auto p = std::find_if(parameters.begin(), parameters.end(),
                                [&](const SurfaceParameter& q) { return q.name == name.text; });
    return static_cast<int>(out.materials.size()) + static_cast<int>(p - parameters.begin());
  };
  out.num_slots = first_signal + static_cast<int>(kNumSignals);
  for (std::size_t r = 0; r < all.size(); ++r) {
    CompiledRule rule;
    rule.rate = all[r].rate;
    rule.driver = compile_expression(drivers[r], slot_of, out.num_slots);
    out.num_slots = std::max(out.num_slots, rule.driver.num_slots);
    const auto add_terms = [&](const MaterialValues& shares) {
      for (std::size_t m = 0; m < names.size(); ++m) {
        if (shares[m] > 0.0)
          rule.form.terms[rule.form.num_terms++] = {out.slot_of_material(static_cast<int>(m)),
                                                    static_cast<float>(shares[m])};
      }
    };
    add_terms(all[r].products);
    rule.form.num_makes = rule.form.num_terms;
    add_terms(all[r].reactants);
    rule.needs = needs_of(rule, out.materials.size());
    out.rules.push_back(std::move(rule));
  }
  return out;
}

}  // namespace patinate::simulation
