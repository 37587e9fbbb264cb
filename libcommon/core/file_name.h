/// \file
/// Names that become names of files: of controls, materials, tiles, scans and job items.
#pragma once

#include <string>
#include <string_view>

namespace patinate {

inline constexpr std::size_t kLongestFileName =
    128;  ///< So that suffixes and temporary names fit into the 255 bytes of file systems.

/// [A-Za-z0-9._-]+, not starting with a dot, at most kLongestFileName: the same file on every system, and never one of
/// another folder.
[[nodiscard]] bool is_file_name(std::string_view name);
/// "letters, digits, dots, `_` and `-`, not a dot first, at most 128": what is_file_name() takes, for errors.
[[nodiscard]] const std::string& file_name_text();
/// @param what  "control". @throws InvalidInput unless is_file_name().
void require_file_name(std::string_view what, std::string_view name);

}  // namespace patinate
