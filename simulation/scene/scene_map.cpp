#include "patinate/simulation/scene_map.h"

#include <algorithm>
#include <cctype>

namespace patinate::simulation {

const std::vector<std::string>& scene_map_kinds() {
  static const std::vector<std::string> kinds = [] {
    std::vector<std::string> list = control_kind_names();
    list.emplace_back("noise");
    list.emplace_back("wood_grain");
    list.emplace_back("objects");
    return list;
  }();
  return kinds;
}

const std::vector<std::string>& built_in_maps() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list = scene_map_kinds();
    std::erase_if(list,
                  [](const std::string& kind) { return kind == "distance" || kind == "image" || kind == "objects"; });
    return list;
  }();
  return names;
}

bool is_map_name(const std::string& text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !text.empty() && is_letter(text.front()) &&
         std::all_of(text.begin(), text.end(), [&](char c) { return is_letter(c) || is_digit(c); });
}

}  // namespace patinate::simulation
