#include "app/request/numbered_path.h"

#include <optional>
#include <string>
#include <string_view>

namespace patinate::app {

namespace {

/// `%d`, `%4d` or `%04d` in a name.
struct NumberField {
  std::size_t begin = 0;
  std::size_t length = 0;
  char fill = ' ';
  std::size_t digits = 0;
};

std::optional<NumberField> find_number(std::string_view name) {
  for (std::size_t begin = name.find('%'); begin != std::string_view::npos; begin = name.find('%', begin + 1)) {
    NumberField field{.begin = begin};
    std::size_t at = begin + 1;
    const auto next = [&] { return at < name.size() ? name[at] : '\0'; };
    if (next() == '0') field.fill = name[at++];
    if (next() >= '1' && next() <= '9') field.digits = static_cast<std::size_t>(name[at++] - '0');
    if (next() != 'd') continue;
    field.length = at + 1 - begin;
    return field;
  }
  return std::nullopt;
}

}  // namespace

bool has_number(const std::filesystem::path& path) { return find_number(path.filename().string()).has_value(); }

std::filesystem::path numbered_path(const std::filesystem::path& path, int index) {
  std::string name = path.filename().string();
  const std::optional<NumberField> field = find_number(name);
  if (!field) return path;
  std::string number = std::to_string(index);
  if (number.size() < field->digits) number.insert(0, field->digits - number.size(), field->fill);
  return path.parent_path() / name.replace(field->begin, field->length, number);
}

}  // namespace patinate::app
