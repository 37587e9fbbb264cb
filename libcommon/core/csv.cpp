#include "libcommon/core/csv.h"

#include "libcommon/core/text.h"

namespace patinate {

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\n") == std::string_view::npos) return std::string(text);
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' ? ' ' : c);
  return out + "\"";
}

std::string csv_cell(const std::optional<double>& value) {
  constexpr int kDigits = 9;
  return value ? number_text(rounded(*value, kDigits) + 0.0) : "";
}

}  // namespace patinate
