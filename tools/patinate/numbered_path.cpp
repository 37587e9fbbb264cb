#include "tools/patinate/numbered_path.h"

#include <regex>
#include <string>

namespace patinate {

namespace {
const std::regex& number_pattern() {
  static const std::regex pattern("%(0?)([1-9]?)d");
  return pattern;
}
}  // namespace

bool has_number(const std::filesystem::path& path) { return std::regex_search(path.filename().string(), number_pattern()); }

std::filesystem::path numbered_path(const std::filesystem::path& path, int index) {
  const std::string name = path.filename().string();
  std::smatch match;
  if (!std::regex_search(name, match, number_pattern())) return path;
  std::string number = std::to_string(index);
  const std::size_t digits = match[2].length() > 0 ? static_cast<std::size_t>(std::stoi(match[2])) : 0;
  if (number.size() < digits) number.insert(0, digits - number.size(), match[1].length() > 0 ? '0' : ' ');
  return path.parent_path() / (match.prefix().str() + number + match.suffix().str());
}

}  // namespace patinate
