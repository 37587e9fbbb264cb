/// \file
/// Single files as outputs: their extension and the content key that they carry.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace patinate {

/// @throws UsageError unless `output` has one of the extensions (lower case, with the dot).
void require_extension(const std::filesystem::path& output, const std::vector<std::string>& extensions);
/// What write_color() can write.
[[nodiscard]] const std::vector<std::string>& image_extensions();
/// The key in an image that patinate wrote; "" if the file is absent or carries none.
[[nodiscard]] std::string image_file_key(const std::filesystem::path& path);

}  // namespace patinate
