/// \file
/// The files that a mesh consists of.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace patinate {

/// Files that a mesh file names and read_mesh() reads with it, as the file names them, decoded: buffers of a glTF.
/// Pictures are not among them.
/// @throws IoError if the file cannot be read; where it is no glTF at all, read_mesh() says so.
[[nodiscard]] std::vector<std::string> mesh_buffer_files(const std::filesystem::path& path);

}  // namespace patinate
