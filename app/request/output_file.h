/// \file
/// Single files as outputs: their extension and the content key that they carry.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libcommon/job/job.h"

namespace patinate::app {

/// @throws UsageError unless `output` has one of the extensions (lower case, with the dot).
void require_extension(const std::filesystem::path& output, const std::vector<std::string>& extensions);
/// For outputs that may be a folder as well as a file of some kinds: any suffix that is none of these is a mistake, not
/// part of a folder's name, but for a version ("textures.v2"), with a slash at the end, or where the folder is there.
/// @param expected  What there is. @throws UsageError
void require_folder_name(const std::filesystem::path& output, const std::string& expected);
/// For outputs that are always folders: the name is not that of an image, a movie, a mesh or a document. @throws
/// UsageError
void require_no_file_name(const std::filesystem::path& output);
/// Extensions that write_color() can write.
[[nodiscard]] const std::vector<std::string>& image_extensions();
/// The key in an image that patinate wrote; "" if the file is absent, carries none, or is cut off.
[[nodiscard]] std::string image_file_key(const std::filesystem::path& path);
/// Key of any file that carries one, by its extension: images, movies, .glb, .usda, .usdz, .obj, .mtl, .mtlx.
[[nodiscard]] std::string written_key(const std::filesystem::path& path);
/// A file that is going to be written, with the key that lies there. A folder of images carries what all of them carry.
[[nodiscard]] OutputFile output_file(const std::filesystem::path& path);
[[nodiscard]] OutputFile output_folder(const std::filesystem::path& path);
/// A file that carries no key: up to date under kSameText when it holds just this text.
[[nodiscard]] OutputFile text_file(const std::filesystem::path& path, const std::string& text);
inline constexpr const char* kSameText = "same";

}  // namespace patinate::app
