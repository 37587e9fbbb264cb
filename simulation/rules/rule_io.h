/// \file
/// Rules as JSON assets (`patinate.rule`, docs/algorithms/aging_rules.md), built in or from files.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/simulation/scene.h"

namespace patinate::simulation {

/// A rule that names materials, whatever a scene's are.
struct RuleAsset {
  std::string name;
  std::string about;  ///< For people; may be empty.
  std::string driver;
  double rate = 0.1;
  std::vector<std::pair<std::string, double>> products;  ///< Material and amount by rate * driver * time, [0, 1000].
  std::vector<std::pair<std::string, double>> reactants;
  std::string where{};  ///< Text of Rule::where.
  std::string layer{};  ///< Rule::layer.
};

/// Names of the rules that come along with the program.
[[nodiscard]] std::vector<std::string> built_in_rule_names();
/// @throws InvalidInput for a name that is not among them, with a did-you-mean.
[[nodiscard]] RuleAsset built_in_rule(const std::string& name);
/// @throws IoError with file and JSON pointer.
[[nodiscard]] RuleAsset load_rule(const std::filesystem::path& path);

/// Whether an element of a scene's "rules" that is text is the path of a file, not the name of a built-in rule.
[[nodiscard]] bool is_rule_path(const std::string& text);

/// For a scene with these materials. A material that the scene calls like a surface parameter is the material.
/// @throws InvalidInput for a material that the scene does not have, or a driver that cannot be read; with a
/// did-you-mean.
/// @param maps  Names of the scene's maps. @param layers  layer_names() of the scene.
[[nodiscard]] Rule resolve_rule(const RuleAsset& asset, std::span<const std::string> materials,
                                std::span<const std::string> maps = {}, std::span<const std::string> layers = {});

/// An element of a scene's "rules": the name of a built-in rule, the path of a file (".json", relative to the scene's
/// folder), or an object: {"name": BUILT-IN or "file": PATH} with any of "driver", "rate", "products", "reactants",
/// "layer" in place of its own, or all of a new rule. A "where" that is no text is left to who calls.
/// @throws IoError with the scene's file and the JSON pointer.
[[nodiscard]] Rule read_scene_rule(JsonReader json, std::span<const std::string> materials,
                                   std::span<const std::string> maps = {}, std::span<const std::string> layers = {});

/// The file of such an element; nothing for a built-in or a new rule.
[[nodiscard]] std::optional<std::filesystem::path> rule_path(const JsonReader& json);

/// Members "rate", "driver", "products", "reactants", "where" of an event that changes rule `target`. Where the scene
/// has no rule of that name, it begins: a built-in one with what is given, or a new one of "driver" and "products" or
/// "reactants".
/// @param json  Its other members are read by who calls.
/// @param rules  The scene's; a rule that events alone bring is in none of them.
/// @throws IoError with the scene's file and the JSON pointer.
[[nodiscard]] RuleChange read_rule_change(JsonReader& json, const std::string& target,
                                          std::span<const std::string> materials, std::span<const Rule> rules,
                                          std::span<const std::string> maps = {},
                                          std::span<const std::string> layers = {});

/// Products or reactants of a rule by name, as files have them: materials, then what it makes or uses of layers.
[[nodiscard]] std::vector<std::pair<std::string, double>> named_shares(const MaterialValues& values,
                                                                       const LayerShares& of_layers,
                                                                       std::span<const std::string> materials);

/// Built-in rules whose materials the scene has, in alphabetical order.
[[nodiscard]] std::vector<RuleAsset> built_in_rules_for(std::span<const std::string> materials);

}  // namespace patinate::simulation
