#include "simulation/rules/compiled_rules.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "patinate/core/error.h"
#include "patinate/simulation/layer_atlas.h"
#include "simulation/rules/rules.h"

namespace patinate::simulation {

namespace {

/// Names beside the materials that a scene's drivers know.
struct KnownNames {
  std::span<const std::string> materials;
  std::span<const std::string> maps;    ///< Beyond the built-in ones.
  std::span<const std::string> layers;  ///< Empty: drivers know no values of layers.
};

/// The driver, where the rule acts at all.
Expression driver_of(const Rule& rule, const KnownNames& known) {
  const std::vector<std::string> names = driver_names(known.materials, known.maps, known.layers);
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

bool is_material(const std::string& name, const KnownNames& known) {
  return std::find(known.materials.begin(), known.materials.end(), name) != known.materials.end();
}

bool is_layer_value(const std::string& name, const KnownNames& known) {
  return !known.layers.empty() && layer_value_of(name, known.materials).has_value();
}

/// Names of a driver that are no materials and no values of layers, those of time or the others.
std::vector<std::string> names_beside(const Rule& rule, const KnownNames& known, bool is_of_time) {
  std::vector<std::string> out;
  for (const ExpressionName& name : driver_of(rule, known).names) {
    if (!is_material(name.text, known) && !is_layer_value(name.text, known) && is_time_signal(name.text) == is_of_time)
      out.push_back(name.text);
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
    needs |= std::uint32_t{1} << rule.form.terms[k].material;  // of layers' states too, which are cut off below
  return needs & ((std::uint32_t{1} << num_materials) - 1);
}

template <class T>
std::size_t index_in(std::vector<T>& list, const T& item) {
  const auto found = std::find(list.begin(), list.end(), item);
  if (found != list.end()) return static_cast<std::size_t>(found - list.begin());
  list.push_back(item);
  return list.size() - 1;
}

/// Finds what occurs in rules, gives it slots, and compiles the rules one by one.
class RuleCompiler {
 public:
  RuleCompiler(std::span<const Rule> all, std::span<const std::string> names,
               std::span<const SurfaceParameter> parameters, const LayerNames& layers)
      : all_(all), names_(names), parameters_(parameters), layers_(layers) {
    for (const SurfaceParameter& parameter : parameters) maps_.push_back(parameter.name);
  }

  [[nodiscard]] CompiledRules compile() {
    for (const Rule& rule : all_) add_driver(rule);
    for (const Rule& rule : all_) add_terms(rule);
    for (std::size_t m = 0; m < names_.size(); ++m) {
      if (occurs_[m]) out_.materials.push_back(static_cast<int>(m));
    }
    first_parameter_ = static_cast<int>(out_.num_changing());
    first_signal_ = first_parameter_ + static_cast<int>(parameters_.size());
    out_.first_layer_value = first_signal_ + static_cast<int>(kNumSignals);
    out_.num_slots = out_.first_layer_value + static_cast<int>(out_.layer_values.size());
    for (std::size_t r = 0; r < all_.size(); ++r) out_.rules.push_back(compiled(all_[r], drivers_[r]));
    return std::move(out_);
  }

 private:
  [[nodiscard]] std::optional<LayerValue> layer_value(const std::string& name) const {
    if (layers_.names.empty()) return std::nullopt;
    const auto m = static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name) - names_.begin());
    if (m == names_.size()) return layer_value_of(name, names_);
    if (!layers_.is_part_of[m]) return std::nullopt;
    return LayerValue{.kind = LayerValueKind::Whole, .material = static_cast<int>(m)};
  }

  void add_driver(const Rule& rule) {
    drivers_.push_back(driver_of(rule, {.materials = names_, .maps = maps_, .layers = layers_.names}));
    for (const ExpressionName& name : drivers_.back().names) {
      const auto m = static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name.text) - names_.begin());
      const std::optional<LayerValue> value = layer_value(name.text);
      if (value) (void)index_in(out_.layer_values, *value);
      if (value && value->kind == LayerValueKind::Interface)
        (void)index_in(out_.layer_states, {LayerStateKind::Interface, value->material});
      if (m < names_.size()) {
        occurs_[m] = true;
      } else if (value) {
        continue;
      } else if (is_time_signal(name.text)) {
        out_.uses[signal_index(name.text)] = true;
      } else if (std::none_of(parameters_.begin(), parameters_.end(),
                              [&](const SurfaceParameter& p) { return p.name == name.text; })) {
        throw InvalidInput("rule '" + rule.name + "' asks for `" + name.text + "`, of which there is no map here");
      }
    }
  }

  void add_terms(const Rule& rule) {
    for (std::size_t m = 0; m < names_.size(); ++m) {
      occurs_[m] = occurs_[m] || rule.products[m] > 0.0 || rule.reactants[m] > 0.0;
      if (rule.layer_products.at_interface[m] > 0.0 || rule.layer_reactants.at_interface[m] > 0.0)
        (void)index_in(out_.layer_states, {LayerStateKind::Interface, static_cast<int>(m)});
    }
    if (rule.layer_reactants.thickness_um > 0.0) (void)index_in(out_.layer_states, {LayerStateKind::Wear});
    if (rule.layer_reactants.adhesion > 0.0) (void)index_in(out_.layer_states, {LayerStateKind::Loosening});
    if (rule.layer_products.stress > 0.0 || rule.layer_reactants.stress > 0.0)
      (void)index_in(out_.layer_states, {LayerStateKind::Stress});
    if (rule.layer.empty() && !rule.changes_layers()) return;
    if (std::find(layers_.names.begin(), layers_.names.end(), rule.layer) == layers_.names.end() &&
        !(rule.layer.empty() && !layers_.names.empty()))
      throw InvalidInput("rule '" + rule.name + "' acts on a layer" +
                         (rule.layer.empty() ? "" : " '" + rule.layer + "'") + ", and the scene has none" +
                         (rule.layer.empty() || layers_.names.empty() ? "" : " of that name"));
  }

  [[nodiscard]] int slot_of(const ExpressionName& name) const {
    if (const std::optional<LayerValue> value = layer_value(name.text)) {
      const auto found = std::find(out_.layer_values.begin(), out_.layer_values.end(), *value);
      return out_.first_layer_value + static_cast<int>(found - out_.layer_values.begin());
    }
    const auto m = std::find(names_.begin(), names_.end(), name.text) - names_.begin();
    if (m < static_cast<std::ptrdiff_t>(names_.size())) return out_.slot_of_material(static_cast<int>(m));
    if (is_time_signal(name.text)) return first_signal_ + static_cast<int>(signal_index(name.text));
    const auto p = std::find_if(parameters_.begin(), parameters_.end(),
                                [&](const SurfaceParameter& q) { return q.name == name.text; });
    return first_parameter_ + static_cast<int>(p - parameters_.begin());
  }

  void add_term(CompiledRule& rule, const std::string& name, int slot, double share) const {
    if (!(share > 0.0)) return;
    if (rule.form.num_terms == kMaxRuleTerms)
      throw InvalidInput("rule '" + name + "' has more than " + std::to_string(kMaxRuleTerms) +
                         " products and reactants");
    rule.form.terms[rule.form.num_terms++] = {slot, static_cast<float>(share)};
  }

  void add_materials(CompiledRule& rule, const std::string& name, const MaterialValues& shares) const {
    for (std::size_t m = 0; m < names_.size(); ++m)
      add_term(rule, name, out_.slot_of_material(static_cast<int>(m)), shares[m]);
  }

  void add_state(CompiledRule& rule, const std::string& name, const LayerState& state, double share) const {
    if (!(share > 0.0)) return;
    const auto found = std::find(out_.layer_states.begin(), out_.layer_states.end(), state);
    const auto index = static_cast<std::size_t>(found - out_.layer_states.begin());
    add_term(rule, name, static_cast<int>(out_.materials.size() + index), share);
    if (std::find(rule.states.begin(), rule.states.end(), index) == rule.states.end()) rule.states.push_back(index);
  }

  void add_interface(CompiledRule& rule, const std::string& name, const MaterialValues& shares) const {
    for (std::size_t m = 0; m < names_.size(); ++m)
      add_state(rule, name, {LayerStateKind::Interface, static_cast<int>(m)}, shares[m]);
  }

  [[nodiscard]] CompiledRule compiled(const Rule& from, const Expression& driver) {
    // A quantum of an amount is as many um as one of a thickness.
    constexpr double kAmountsPerUm = double{LayerAtlas::kQuantaPerUm} / kAmountOne;
    CompiledRule rule;
    rule.rate = from.rate;
    rule.driver = compile_expression(
        driver, [&](const ExpressionName& name) { return slot_of(name); }, out_.num_slots);
    out_.num_slots = std::max(out_.num_slots, rule.driver.num_slots);
    add_materials(rule, from.name, from.products);
    add_interface(rule, from.name, from.layer_products.at_interface);
    add_state(rule, from.name, {LayerStateKind::Stress}, from.layer_products.stress);
    add_state(rule, from.name, {LayerStateKind::Wear}, from.layer_reactants.thickness_um * kAmountsPerUm);
    add_state(rule, from.name, {LayerStateKind::Loosening}, from.layer_reactants.adhesion);
    rule.form.num_makes = rule.form.num_terms;
    add_materials(rule, from.name, from.reactants);
    add_interface(rule, from.name, from.layer_reactants.at_interface);
    add_state(rule, from.name, {LayerStateKind::Stress}, from.layer_reactants.stress);
    rule.needs = needs_of(rule, out_.materials.size());
    rule.acts_on_layer = from.changes_layers() || !from.layer.empty();
    rule.target = static_cast<int>(index_in(out_.targets, from.layer));
    for (const ExpressionName& name : driver.names) {
      if (const std::optional<LayerValue> value = layer_value(name.text))
        rule.values.push_back(index_in(out_.layer_values, *value));
    }
    return rule;
  }

  std::span<const Rule> all_;
  std::span<const std::string> names_;
  std::span<const SurfaceParameter> parameters_;
  const LayerNames& layers_;
  std::vector<std::string> maps_;
  std::vector<Expression> drivers_;
  std::array<bool, kMaxMaterials> occurs_{};
  int first_parameter_ = 0;
  int first_signal_ = 0;
  CompiledRules out_;
};

}  // namespace

std::vector<std::string> parameters_of(const Rule& rule, std::span<const std::string> materials,
                                       std::span<const std::string> maps, std::span<const std::string> layers) {
  return names_beside(rule, {.materials = materials, .maps = maps, .layers = layers}, false);
}

std::vector<std::string> signals_of(const Rule& rule, std::span<const std::string> materials,
                                    std::span<const std::string> maps, std::span<const std::string> layers) {
  return names_beside(rule, {.materials = materials, .maps = maps, .layers = layers}, true);
}

int CompiledRules::slot_of_material(int material) const {
  return static_cast<int>(std::find(materials.begin(), materials.end(), material) - materials.begin());
}

bool CompiledRules::has_layers() const {
  return std::any_of(rules.begin(), rules.end(), [](const CompiledRule& rule) { return rule.has_layers(); });
}

CompiledRules compile_rules(std::span<const Rule> all, std::span<const std::string> names,
                            std::span<const SurfaceParameter> parameters, const LayerNames& layers) {
  return RuleCompiler(all, names, parameters, layers).compile();
}

}  // namespace patinate::simulation
