#include "simulation/rules/rule_io.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/rules/layer_values.h"
#include "simulation/rules/rules.h"

namespace patinate::simulation {

extern const std::string_view kRuleRust;
extern const std::string_view kRuleRustConsuming;
extern const std::string_view kRuleDecay;
extern const std::string_view kRuleDecayTwoRates;
extern const std::string_view kRuleGrowth;
extern const std::string_view kRuleEvaporation;
extern const std::string_view kRuleEvaporationConstant;
extern const std::string_view kRulePatina;
extern const std::string_view kRuleDust;
extern const std::string_view kRuleMoss;
extern const std::string_view kRuleFading;
extern const std::string_view kRuleWetting;

namespace {

constexpr Range kRateRange{.low = 0.0, .high = 1e6};  ///< Ranges of an untrusted file.
constexpr Range kShareRange{.low = 0.0, .high = 1e3};
constexpr std::string_view kThickness = "thickness";
constexpr std::string_view kAdhesion = "adhesion";
constexpr std::string_view kStress = "stress";

/// Whether products and reactants of this name are of a layer.
bool is_of_layer(std::string_view name) {
  return name == kThickness || name == kAdhesion || name == kStress || interface_material(name).has_value();
}

struct BuiltIn {
  std::string_view name;
  const std::string_view* text;
};
constexpr std::array<BuiltIn, 12> kBuiltIns{{{"rust", &kRuleRust},
                                             {"rust_consuming", &kRuleRustConsuming},
                                             {"decay", &kRuleDecay},
                                             {"decay_two_rates", &kRuleDecayTwoRates},
                                             {"growth", &kRuleGrowth},
                                             {"evaporation", &kRuleEvaporation},
                                             {"evaporation_constant", &kRuleEvaporationConstant},
                                             {"patina", &kRulePatina},
                                             {"dust", &kRuleDust},
                                             {"moss", &kRuleMoss},
                                             {"fading", &kRuleFading},
                                             {"wetting", &kRuleWetting}}};

std::vector<std::pair<std::string, double>> read_shares(JsonReader json) {
  std::vector<std::pair<std::string, double>> out;
  for (const std::string& name : json.keys()) out.emplace_back(name, json.member(name).number(kShareRange));
  const auto num_materials =
      std::count_if(out.begin(), out.end(), [](const auto& share) { return !is_of_layer(share.first); });
  if (num_materials > kMaxMaterials) json.fail("at most " + std::to_string(kMaxMaterials) + " materials");
  return out;
}

/// Reads what is there into `asset`.
void read_fields(JsonReader& json, RuleAsset& asset) {
  if (json.has("driver")) asset.driver = json.member("driver").string();
  if (json.has("rate")) asset.rate = json.member("rate").number(kRateRange);
  if (json.has("products")) asset.products = read_shares(json.member("products"));
  if (json.has("reactants")) asset.reactants = read_shares(json.member("reactants"));
  if (json.has("where")) {
    const JsonReader where = json.member("where");
    if (where.is_string()) asset.where = where.string();
  }
  if (json.has("layer")) asset.layer = json.member("layer").string();
}

RuleAsset read_rule(JsonReader json) {
  json.expect_format("patinate.rule", 2);
  RuleAsset asset;
  asset.name = json.member("name").string();
  (void)json.member("driver");
  read_fields(json, asset);
  if (json.has("about")) asset.about = json.member("about").string();
  if (json.has("where")) (void)json.member("where").string();  // what a scene alone can name is in none
  json.finish();
  if (asset.products.empty() && asset.reactants.empty()) json.fail("a rule that has products or reactants");
  return asset;
}

/// A string, or an object with what is changed.
RuleAsset read_asset(JsonReader& json) {
  const std::vector<std::string> names = built_in_rule_names();
  const auto built_in_or_fail = [&](const JsonReader& at, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) != names.end()) return built_in_rule(name);
    std::string list;
    for (const std::string& each : names) list += each + ", ";
    at.fail("a built-in rule (" + list.substr(0, list.size() - 2) + ") or the path of a .json file" +
            did_you_mean(name, names));
  };
  if (json.is_string())
    return is_rule_path(json.string()) ? load_rule(json.path()) : built_in_or_fail(json, json.string());
  if (!json.is_object()) json.fail("the name of a rule, a path, or an object");
  RuleAsset asset;
  if (json.has("file")) {
    asset = load_rule(json.member("file").path());
    if (json.has("name")) asset.name = json.member("name").string();
  } else {
    const JsonReader name = json.member("name");
    const bool is_new = json.has("driver") && (json.has("products") || json.has("reactants"));
    if (is_new && std::find(names.begin(), names.end(), name.string()) == names.end()) {
      asset.name = name.string();
    } else {
      asset = built_in_or_fail(name, name.string());
    }
  }
  read_fields(json, asset);
  if (json.has("about")) asset.about = json.member("about").string();
  json.finish();
  return asset;
}

/// Products or reactants of a rule. @param list  Their name.
struct ResolvedShares {
  MaterialValues materials{};
  LayerShares layer{};
};

class ShareResolver {
 public:
  ShareResolver(const RuleAsset& asset, std::span<const std::string> materials, std::span<const std::string> layers)
      : asset_(asset), materials_(materials), layers_(layers) {}

  [[nodiscard]] ResolvedShares resolve(const std::vector<std::pair<std::string, double>>& shares,
                                       const std::string& list) const {
    ResolvedShares out;
    for (const auto& [name, share] : shares) {
      const bool is_material =
          layers_.empty() && std::find(materials_.begin(), materials_.end(), name) != materials_.end();
      if (is_material || !is_of_layer(name)) {
        out.materials[material(name, name, list)] = share;
        continue;
      }
      if (layers_.empty())
        throw InvalidInput(place(list) + "`" + name + "` is of layers, and no object of the scene has any");
      if (const auto of_interface = interface_material(name)) {
        out.layer.at_interface[material(std::string(*of_interface), name, list)] = share;
      } else if (name == kStress) {
        out.layer.stress = share;
      } else if (list == "products") {
        throw InvalidInput(place(list) + "a layer's " + name + " only falls; use it in reactants");
      } else {
        (name == kThickness ? out.layer.thickness_um : out.layer.adhesion) = share;
      }
    }
    return out;
  }

 private:
  [[nodiscard]] std::string place(const std::string& list) const { return list + " of rule '" + asset_.name + "': "; }
  [[nodiscard]] std::size_t material(const std::string& name, const std::string& written,
                                     const std::string& list) const {
    const auto found = std::find(materials_.begin(), materials_.end(), name);
    if (found == materials_.end()) {
      throw InvalidInput(place(list) + "`" + written + "` is none of the scene's materials" +
                         did_you_mean(name, materials_));
    }
    return static_cast<std::size_t>(found - materials_.begin());
  }

  const RuleAsset& asset_;
  std::span<const std::string> materials_;
  std::span<const std::string> layers_;
};

void check_layer(const RuleAsset& asset, std::span<const std::string> layers) {
  if (asset.layer.empty() || std::find(layers.begin(), layers.end(), asset.layer) != layers.end()) return;
  std::string list;
  for (const std::string& name : layers) list += (list.empty() ? " (" : ", ") + name;
  throw InvalidInput("layer of rule '" + asset.name + "': `" + asset.layer +
                     "` is none of the layers above substrates" + (list.empty() ? "" : list + ")") +
                     did_you_mean(asset.layer, layers));
}

/// Result of `make`; its errors name this place.
template <class Make>
auto at_place(const JsonReader& json, Make&& make) {
  try {
    return make();
  } catch (const InvalidInput& e) {
    throw IoError(json.file(), json.pointer() + ": " + e.what());
  }
}

}  // namespace

bool is_rule_path(const std::string& text) { return text.ends_with(".json") || text.find('/') != std::string::npos; }

std::vector<std::string> built_in_rule_names() {
  std::vector<std::string> names;
  for (const BuiltIn& rule : kBuiltIns) names.emplace_back(rule.name);
  return names;
}

RuleAsset built_in_rule(const std::string& name) {
  for (const BuiltIn& rule : kBuiltIns) {
    if (rule.name == name)
      return read_rule(JsonReader("built-in rule " + name, Json::parse(*rule.text, nullptr, true, true)));
  }
  throw InvalidInput("there is no built-in rule `" + name + "`" + did_you_mean(name, built_in_rule_names()));
}

RuleAsset load_rule(const std::filesystem::path& path) {
  Json json = load_json(path);
  update_spelling(json, 1, {{"alpha", "rate"}, {"makes", "products"}, {"uses", "reactants"}});
  return read_rule(JsonReader(path.string(), json));
}

Rule resolve_rule(const RuleAsset& asset, std::span<const std::string> materials, std::span<const std::string> maps,
                  std::span<const std::string> layers) {
  const ShareResolver resolver(asset, materials, layers);
  const ResolvedShares products = resolver.resolve(asset.products, "products"),
                       reactants = resolver.resolve(asset.reactants, "reactants");
  check_layer(asset, layers);
  Rule rule{.name = asset.name,
            .driver = asset.driver,
            .rate = asset.rate,
            .products = products.materials,
            .reactants = reactants.materials,
            .where = asset.where,
            .layer = asset.layer,
            .layer_products = products.layer,
            .layer_reactants = reactants.layer};
  (void)parameters_of(rule, materials, maps, layers);  // reads the driver
  return rule;
}

Rule read_scene_rule(JsonReader json, std::span<const std::string> materials, std::span<const std::string> maps,
                     std::span<const std::string> layers) {
  const RuleAsset asset = read_asset(json);
  return at_place(json, [&] { return resolve_rule(asset, materials, maps, layers); });
}

std::optional<std::filesystem::path> rule_path(const JsonReader& json) {
  if (json.is_string()) return is_rule_path(json.string()) ? std::optional(json.path()) : std::nullopt;
  JsonReader members = json;
  return members.has("file") ? std::optional(members.member("file").path()) : std::nullopt;
}

RuleChange read_rule_change(JsonReader& json, const std::string& target, std::span<const std::string> materials,
                            std::span<const Rule> rules, std::span<const std::string> maps,
                            std::span<const std::string> layers) {
  RuleAsset given{.name = target,
                  .about = {},
                  .driver = {},
                  .rate = 0.1,
                  .products = {},
                  .reactants = {},
                  .where = {},
                  .layer = {}};
  read_fields(json, given);
  if (json.has("where")) (void)json.member("where").string();
  const Rule rule = at_place(json, [&] {
    RuleAsset whole = given;
    if (whole.driver.empty()) whole.driver = "0";
    return resolve_rule(whole, materials, maps, layers);
  });
  RuleChange change;
  if (json.has("driver")) change.driver = rule.driver;
  if (json.has("rate")) change.rate = rule.rate;
  if (json.has("products")) change.products = rule.products;
  if (json.has("reactants")) change.reactants = rule.reactants;
  if (json.has("products") && !layers.empty()) change.layer_products = rule.layer_products;
  if (json.has("reactants") && !layers.empty()) change.layer_reactants = rule.layer_reactants;
  if (json.has("where")) change.where = rule.where;
  const auto num_known = std::count_if(rules.begin(), rules.end(), [&](const Rule& r) { return r.name == target; });
  if (num_known > 1)
    json.member("target").fail("a name that one rule has: " + std::to_string(num_known) + " are called so");
  const bool is_empty = !change.driver && !change.rate && !change.products && !change.reactants && !change.where;
  if (num_known == 1) {
    if (json.has("layer")) json.member("layer").fail("none: a rule acts on the same layer as before");
    if (is_empty) json.fail("any of \"driver\", \"rate\", \"reactants\", \"products\", \"where\"");
    return change;
  }
  const std::vector<std::string> names = built_in_rule_names();
  if (std::find(names.begin(), names.end(), target) != names.end()) {
    RuleAsset asset = built_in_rule(target);
    if (json.has("driver")) asset.driver = given.driver;
    if (json.has("rate")) asset.rate = given.rate;
    if (json.has("products")) asset.products = given.products;
    if (json.has("reactants")) asset.reactants = given.reactants;
    if (json.has("where")) asset.where = given.where;
    if (json.has("layer")) asset.layer = given.layer;
    change.begins = at_place(json, [&] { return resolve_rule(asset, materials, maps, layers); });
  } else if (change.driver && (change.products || change.reactants)) {
    change.begins = rule;
  }
  return change;
}

std::vector<std::pair<std::string, double>> named_shares(const MaterialValues& values, const LayerShares& of_layers,
                                                         std::span<const std::string> materials) {
  std::vector<std::pair<std::string, double>> shares;
  const auto add = [&](std::string name, double share) {
    if (share > 0.0) shares.emplace_back(std::move(name), share);
  };
  for (std::size_t m = 0; m < materials.size(); ++m) add(materials[m], values[m]);
  for (std::size_t m = 0; m < materials.size(); ++m) add("interface." + materials[m], of_layers.at_interface[m]);
  add(std::string(kThickness), of_layers.thickness_um);
  add(std::string(kAdhesion), of_layers.adhesion);
  add(std::string(kStress), of_layers.stress);
  return shares;
}

std::vector<RuleAsset> built_in_rules_for(std::span<const std::string> materials) {
  std::vector<RuleAsset> fitting;
  for (const std::string& name : built_in_rule_names()) {
    RuleAsset asset = built_in_rule(name);
    try {
      (void)resolve_rule(asset, materials);
    } catch (const InvalidInput&) {
      continue;  // it is about other materials
    }
    fitting.push_back(std::move(asset));
  }
  std::sort(fitting.begin(), fitting.end(), [](const RuleAsset& a, const RuleAsset& b) { return a.name < b.name; });
  return fitting;
}

}  // namespace patinate::simulation
