/// \file
/// Single files as outputs: their extension and the content key that they carry.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace patinate::cli {

/// @throws UsageError unless `output` has one of the extensions (lower case, with the dot).
void require_extension(const std::filesystem::path& output, const std::vector<std::string>& extensions);
/// For outputs that may be a folder as well as a file of some kinds: any suffix that is none of these is a mistake, not
/// part of a folder's name, but for a version ("textures.v2"), with a slash at the end, or where the folder is there.
/// @param expected  What there is. @throws UsageError
void require_folder_name(const std::filesystem::path& output, const std::string& expected);
/// For outputs that are always folders: the name is not that of an image, a movie, a mesh or a document. @throws
/// UsageError
void require_no_file_name(const std::filesystem::path& output);
/// What write_color() can write.
[[nodiscard]] const std::vector<std::string>& image_extensions();
/// The key in an image that patinate wrote; "" if the file is absent or carries none.
[[nodiscard]] std::string image_file_key(const std::filesystem::path& path);

}  // namespace patinate::cli
