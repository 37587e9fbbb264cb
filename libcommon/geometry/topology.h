/// \file
/// How a mesh hangs together, seen as an OpenMesh.
#pragma once

#include "patinate/geometry/mesh.h"

namespace patinate {

struct MeshTopology {
  int num_parts = 0;           ///< Pieces connected over edges.
  int num_boundary_loops = 0;  ///< Closed chains of edges that only one triangle has.
  int num_nonmanifold_triangles =
      0;  ///< Triangles that no oriented surface can hold beside those before them; excluded from the other figures.
  int euler_characteristic = 0;  ///< V - E + F over what triangles use: 2 for a sphere, 0 for a torus, 1 for a disc.
  /// Every edge has two triangles that agree in orientation.
  [[nodiscard]] bool is_closed() const { return num_boundary_loops == 0 && num_nonmanifold_triangles == 0; }
};

/// By positions: UV seams and hard edges do not cut. O(triangles).
[[nodiscard]] MeshTopology mesh_topology(const Mesh& mesh);

}  // namespace patinate
