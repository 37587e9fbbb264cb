/// \file
/// Names of image sequences: "aged_%04d.png".
#pragma once

#include <filesystem>

namespace patinate::app {

/// The file name holds `%d`, or `%04d` with any number of digits.
[[nodiscard]] bool has_number(const std::filesystem::path& path);
/// The name of image `index` of a sequence. @pre has_number(path)
[[nodiscard]] std::filesystem::path numbered_path(const std::filesystem::path& path, int index);

}  // namespace patinate::app
