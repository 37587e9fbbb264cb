/// \file
/// Names that become names of files: of controls, materials, tiles, scans and job items.
#pragma once

#include <filesystem>
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

/// ASCII letters in lower case, everything else as it is.
[[nodiscard]] std::string lower_case(std::string_view text);
/// The extension with its dot, in lower case: ".png" of "a.PNG".
[[nodiscard]] std::string lower_extension(const std::filesystem::path& path);

}  // namespace patinate
