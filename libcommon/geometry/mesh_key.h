/// \file
/// What a result depends on when it depends on a mesh.
#pragma once

#include <string>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Content key of positions, UVs, normals and triangles, whatever files they came from.
[[nodiscard]] std::string mesh_content_key(const Mesh& mesh);

}  // namespace patinate
