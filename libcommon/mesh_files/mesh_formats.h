/// \file
/// The readers behind read_mesh(), one per format, and OBJ with materials. Each takes the path for its error messages.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// v, vt, vn, f (polygons, negative indices, continued lines), o, usemtl. Numbers are read to the last bit; a line that
/// cannot be understood is named. (tinyobjloader reads "nan" as 0, rounds numbers and does not continue lines.)
[[nodiscard]] Mesh read_obj(const std::filesystem::path& path);

/// ASCII and both binary forms; per-vertex (s, t), (u, v) or (texture_u, texture_v); per-face `texcoord` lists;
/// tristrips.
[[nodiscard]] Mesh read_ply(const std::filesystem::path& path);

/// ASCII, of one or several solids, and binary. Facets' normals follow from their corners. (OpenMesh's reader goes on
/// behind the end of a file that is cut off.)
[[nodiscard]] Mesh read_stl(const std::filesystem::path& path);

/// glTF and GLB, version 2, through tinygltf: the default scene's nodes with their transforms and instances, all
/// primitives of triangles, strips and fans, as they stand at rest: skins where their joints are, morph targets by
/// their default weights. UVs are those of the material's base color, with its texture transform. Images and animations
/// are not looked at. Extensions that a file requires are known or refused by name (gltf_json.h).
/// @param notes  Takes lines about what the file has and is not read; may be null.
[[nodiscard]] Mesh read_gltf(const std::filesystem::path& path, std::vector<std::string>* notes);

/// The OBJ that mesh_io.h writes, with materials. @param material_library  An MTL file that says what they are; "" =
/// none.
void write_obj(const std::filesystem::path& path, const Mesh& mesh, const std::string& key,
               const std::string& material_library);

}  // namespace patinate
