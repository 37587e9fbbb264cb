/// \file
/// Cells of tables of comma-separated values [RFC 4180].
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace patinate {

/// In quotes where a comma, a quote or a line's end would break the row; ends of lines become blanks.
[[nodiscard]] std::string csv_cell(std::string_view text);
/// Nine significant digits; empty where there is no value.
[[nodiscard]] std::string csv_cell(const std::optional<double>& value);

}  // namespace patinate
