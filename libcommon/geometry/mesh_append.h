/// \file
/// Several meshes as one.
#pragma once

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Puts the triangles of a mesh behind those of another one; positions, UVs, normals and surfaces stay apart.
/// @param to  Empty, or with UVs and normals where `from` has them.
void append_mesh(Mesh& to, const Mesh& from);

}  // namespace patinate
