/// \file
/// The files that a mesh consists of, and what they say besides its surface.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace patinate {

/// Whether the file is glTF or GLB by its name, and so in meters; other mesh files have no unit.
[[nodiscard]] bool is_gltf_file(const std::filesystem::path& path);

/// Extensions of glTF that a file uses; of other files there are none.
struct MeshFileExtensions {
  std::vector<std::string> read;     ///< They change the surface, and are read.
  std::vector<std::string> ignored;  ///< Not looked at: of materials and lights, or not needed to read the file.
};
/// @throws IoError as read_mesh()
[[nodiscard]] MeshFileExtensions mesh_file_extensions(const std::filesystem::path& path);

/// Files that a mesh file names and read_mesh() reads with it, as the file names them, decoded: buffers of a glTF.
/// Pictures are not among them.
/// @throws IoError if the file cannot be read, is no glTF 2, or needs an extension that read_mesh() does not know.
[[nodiscard]] std::vector<std::string> mesh_buffer_files(const std::filesystem::path& path);

}  // namespace patinate
