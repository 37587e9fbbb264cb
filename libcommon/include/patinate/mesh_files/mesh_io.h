/// \file
/// OBJ, PLY, STL, glTF and GLB (tinygltf). Files are not trusted: every count is bounded before allocating.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Reads by extension (.obj, .ply, .stl, .gltf, .glb). Polygons are triangulated, degenerate triangles (repeated
/// corner) dropped, positions that are equal within a node are merged, node transforms applied (glTF meters are kept as
/// they are). Node and material names fill `surfaces`; OBJ groups (`o`) and STL solids are nodes. glTF stands at
/// rest, with UVs flipped to v up. Corners without UV have the index -1 (uv_triangles is empty when none has one);
/// corners without a normal get the angle-weighted one when others have theirs.
/// @throws IoError if it is missing, truncated, malformed, has no faces (a point cloud says so), or a NaN or index out
/// of range.
/// @param notes  Takes lines about what the file has and is not read, such as animations; may be null.
[[nodiscard]] Mesh read_mesh(const std::filesystem::path& path, std::vector<std::string>* notes = nullptr);

/// OBJ with positions, UVs and normals; numbers read back exactly; no date.
/// @param key  Content key, kept in a comment; "" = none. @throws CannotComplete
void write_obj(const std::filesystem::path& path, const Mesh& mesh, const std::string& key = "");
/// The content key in an OBJ that write_obj() made; "" if there is none, or no such file.
[[nodiscard]] std::string read_obj_key(const std::filesystem::path& path);

}  // namespace patinate
