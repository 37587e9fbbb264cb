#include "libcommon/core/file_name.h"

#include <algorithm>

#include "patinate/core/error.h"

namespace patinate {

bool is_file_name(std::string_view name) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
           c == '-';
  };
  return !name.empty() && name.size() <= kLongestFileName && name.front() != '.' &&
         std::all_of(name.begin(), name.end(), is_allowed);
}

const std::string& file_name_text() {
  static const std::string text =
      "letters, digits, dots, `_` and `-`, not a dot first, at most " + std::to_string(kLongestFileName);
  return text;
}

void require_file_name(std::string_view what, std::string_view name) {
  if (!is_file_name(name))
    throw InvalidInput(std::string(what) + " `" + std::string(name) + "`: names consist of " + file_name_text());
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

std::string lower_extension(const std::filesystem::path& path) { return lower_case(path.extension().string()); }

}  // namespace patinate
