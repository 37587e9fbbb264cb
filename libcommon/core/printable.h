/// \file
/// Text from files and command lines as a terminal may show it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace patinate {

inline constexpr std::size_t kLongestLine =
    2000;  ///< Bytes. Nobody reads more, and a damaged file may hold a line of gigabytes.

/// One line: control characters, characters that turn the direction of writing and bytes that are no UTF-8 as `\x1b`;
/// new lines as blanks; what is longer than `max_bytes` (>= 100) shortened in the middle, which says by how much.
[[nodiscard]] std::string printable_line(std::string_view text, std::size_t max_bytes = kLongestLine);
/// Makes each of several lines printable; new lines stay.
[[nodiscard]] std::string printable_lines(std::string_view text, std::size_t max_bytes = kLongestLine);

}  // namespace patinate
