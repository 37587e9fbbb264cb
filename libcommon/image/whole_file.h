/// \file
/// Whether a photograph's file was written to its end, without decoding it.
#pragma once

#include <filesystem>

namespace patinate {

/// Whether a PNG's chunks or a JPEG's picture break off before their end. Files of other formats are never said to.
/// Reads heads of parts and the end; all of a JPEG that does not end with its picture, in blocks of a megabyte.
/// @param path  That probe_image() takes.
/// @returns false, too, where the file cannot be read.
[[nodiscard]] bool is_cut_off(const std::filesystem::path& path);

}  // namespace patinate
