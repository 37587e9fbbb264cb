#include "app/fit/scene_pointer.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "libcommon/core/text.h"
#include "patinate/history/history_value.h"
#include "patinate/simulation/scene_io.h"

namespace patinate::app {

namespace {

std::string unescaped(std::string token) {
  for (const auto& [from, to] : {std::pair{"~1", "/"}, std::pair{"~0", "~"}}) {
    for (std::size_t at = token.find(from); at != std::string::npos; at = token.find(from, at + 1))
      token.replace(at, 2, to);
  }
  return token;
}

std::string escaped(const std::string& token) {
  std::string out;
  for (char c : token) out += c == '~' ? std::string("~0") : c == '/' ? std::string("~1") : std::string(1, c);
  return out;
}

std::vector<std::string> tokens_of(const std::string& pointer) {
  std::vector<std::string> tokens;
  for (std::size_t begin = 1; begin <= pointer.size();) {
    const std::size_t end = std::min(pointer.find('/', begin), pointer.size());
    tokens.push_back(unescaped(pointer.substr(begin, end - begin)));
    begin = end + 1;
  }
  return tokens;
}

/// The place in an array that a token names.
std::optional<std::size_t> index_of(const Json& array, const std::string& token) {
  if (token.empty() || token.size() >= 8 || token.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  const std::size_t index = std::stoul(token);
  return index < array.size() ? std::optional(index) : std::nullopt;
}

/// Whose members are named things, and what one of them is called.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kNamedThings{{{"emitters", "emitter"},
                                                                                     {"rules", "rule"},
                                                                                     {"objects", "object"},
                                                                                     {"appearance", "appearance of"},
                                                                                     {"presets", "preset"}}};
constexpr std::array<std::string_view, 3> kChannels{"red", "green", "blue"}, kAxes{"x", "y", "z"};

/// "rain" of /emitters/0, "patina" of /appearance/patina; nothing where it has no name.
std::optional<std::string> thing_name(const Json& list, const std::string& token) {
  if (list.is_object()) return token;
  const std::optional<std::size_t> index = list.is_array() ? index_of(list, token) : std::nullopt;
  if (!index) return std::nullopt;
  const Json& thing = list[*index];
  if (thing.is_object() && thing.contains("name") && thing["name"].is_string()) return thing["name"].get<std::string>();
  return std::nullopt;
}

/// A token as a word: the channel of a color, the axis of another triple.
std::string word_of(const std::string& token, const std::string& before, bool is_of_triple) {
  if (is_of_triple) return std::string((before == "color" ? kChannels : kAxes)[std::stoul(token)]);
  std::string word = token;
  std::replace(word.begin(), word.end(), '_', ' ');
  return word;
}

/// Numbers with a unit: pointers, where * is any token. {L} is the scene's unit of length, {T} that of time.
constexpr std::array<std::pair<std::string_view, std::string_view>, 16> kPointerUnits{
    {{"/rules/*/rate", "per {T}"},
     {"/rules/*/alpha", "per {T}"},
     {"/time/per_iteration", "{T}"},
     {"/exchange/rates/*", "per contact"},
     {"/exchange/splat_mm", "mm"},
     {"/emitters/*/carries/*", "layers"},
     {"/objects/*/initial/*", "layers"},
     {"/objects/*/initial/*/amount", "layers"},
     {"/presets/*/composition/*", "layers"},
     {"/emitters/*/speed", "{L}/s"},
     {"/emitters/*/distance", "{L}"},
     {"/emitters/*/position/*", "{L}"},
     {"/objects/*/translate/*", "{L}"},
     {"/appearance/*/strength", "per layer"},
     {"/appearance/*/height", "mm"},
     {"/appearance/*/grain", "mm"}}};

bool is_like(const std::vector<std::string>& tokens, const std::vector<std::string>& pattern) {
  return std::equal(tokens.begin(), tokens.end(), pattern.begin(), pattern.end(),
                    [](const std::string& token, const std::string& p) { return p == "*" || p == token; });
}

}  // namespace

Json* found_at(Json& root, const std::string& pointer) {
  Json* at = &root;
  for (const std::string& token : tokens_of(pointer)) {
    if (at->is_object() && at->contains(token)) {
      at = &(*at)[token];
      continue;
    }
    const std::optional<std::size_t> index = at->is_array() ? index_of(*at, token) : std::nullopt;
    if (!index) return nullptr;
    at = &(*at)[*index];
  }
  return at;
}

void collect_numbers(const Json& json, const std::string& pointer, const std::vector<std::string>& left_out,
                     std::vector<std::string>& out) {
  if (json.is_number() && std::find(left_out.begin(), left_out.end(), pointer) == left_out.end())
    out.push_back(pointer);
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) collect_numbers(value, pointer + "/" + escaped(key), left_out, out);
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i)
      collect_numbers(json[i], pointer + "/" + std::to_string(i), left_out, out);
  }
}

std::string nearest_pointers(const std::string& pointer, const std::vector<std::string>& all) {
  if (const std::string one = did_you_mean(pointer, all); !one.empty()) return one;
  const auto common = [&](const std::string& other) {
    return static_cast<std::size_t>(std::mismatch(pointer.begin(), pointer.end(), other.begin(), other.end()).first -
                                    pointer.begin());
  };
  std::vector<std::string> sorted = all;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const std::string& a, const std::string& b) { return common(a) > common(b); });
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, sorted.size()); ++i)
    text += (text.empty() ? "" : ", ") + sorted[i];
  return text.empty() ? "" : "; numbers of the scene that are named most alike: " + text;
}

std::string words_of(const Json& root, const std::string& pointer) {
  const std::vector<std::string> tokens = tokens_of(pointer);
  const auto kind = std::find_if(kNamedThings.begin(), kNamedThings.end(),
                                 [&](const auto& k) { return !tokens.empty() && k.first == tokens.front(); });
  if (tokens.empty() || !root.contains(tokens.front())) return pointer;
  std::string text;
  std::size_t next = 0;
  const Json* at = &root;
  if (kind != kNamedThings.end()) {
    const Json& list = root[tokens.front()];
    const std::optional<std::string> name = tokens.size() > 2 ? thing_name(list, tokens[1]) : std::nullopt;
    if (!name) return pointer;
    text = std::string(kind->second) + " " + *name + ":";
    at = list.is_object() ? &list[tokens[1]] : &list[*index_of(list, tokens[1])];
    next = 2;
  }
  for (; next < tokens.size(); ++next) {
    const std::string& token = tokens[next];
    const bool is_of_triple = at->is_array() && at->size() == 3 && index_of(*at, token).has_value();
    if (at->is_array() && !is_of_triple) return pointer;  // A list of things without names.
    text += (text.empty() ? "" : " ") + word_of(token, next > 0 ? tokens[next - 1] : "", is_of_triple);
    if (!is_of_triple && !(at->is_object() && at->contains(token))) return pointer;
    at = is_of_triple ? &(*at)[*index_of(*at, token)] : &(*at)[token];
  }
  return text;
}

std::string unit_of(const Json& root, const std::string& pointer) {
  const std::vector<std::string> tokens = tokens_of(pointer);
  const auto found = std::find_if(kPointerUnits.begin(), kPointerUnits.end(),
                                  [&](const auto& u) { return is_like(tokens, tokens_of(std::string(u.first))); });
  if (found == kPointerUnits.end()) return "";
  std::string unit(found->second);
  const Json time = root.value("time", Json::object());
  for (const auto& [mark, text] : {std::pair<std::string, std::string>{"{L}", root.value("unit", "mm")},
                                   {"{T}", time.value("unit", time_unit_text(simulation::SceneFile{}.time_unit))}}) {
    if (const std::size_t at = unit.find(mark); at != std::string::npos) unit.replace(at, mark.size(), text);
  }
  return unit;
}

}  // namespace patinate::app
