#include "app/request/repeating_command.h"

namespace patinate::app {

std::string shell_word(const std::string& word) {
  if (!word.empty() &&
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._/-=:,+@%") ==
          std::string::npos)
    return word;
  std::string out = "'";
  for (char c : word) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

std::string input_name(const std::filesystem::path& path) {
  const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

std::string input_word(const std::filesystem::path& path) { return shell_word(input_name(path)); }

std::string changed_options(const std::vector<std::pair<std::string, std::string>>& values,
                            const std::vector<std::pair<std::string, std::string>>& defaults) {
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i].second == defaults[i].second) continue;
    std::string name = values[i].first;
    for (char& c : name) c = c == '_' ? '-' : c;
    text += " --" + name + (values[i].second == "true" ? "" : " " + values[i].second);
  }
  return text;
}

}  // namespace patinate::app
