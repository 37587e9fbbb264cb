/// \file
/// What real mesh files hold that a surface should not: found, counted, and repaired where that changes nothing one can
/// see.
#pragma once

#include <string>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Findings of repair_mesh().
struct MeshRepairs {
  int num_degenerate = 0;  ///< Triangles without area (a sine below 1e-12 at every corner): excluded.
  int num_duplicates =
      0;               ///< Triangles with the corners, UVs and surface of an earlier one, either way round: excluded.
  int num_turned = 0;  ///< Triangles that faced the other way than most of their piece's area: turned.
  int num_complex_edges =
      0;  ///< Edges that more than two triangles share: kept; the surface continues where it bends least.
  /// "2 triangles without area excluded; 1 triangle turned to face as its neighbors do"; "" when there is nothing to
  /// say.
  [[nodiscard]] std::string text() const;
};

struct RepairedMesh {
  Mesh mesh;
  MeshRepairs repairs;
};

/// The mesh that algorithms can rely on: every triangle has an area, none is there twice, and neighbors face the same
/// way where the surface allows it. A clean mesh comes back unchanged. Pieces stay as they are as a whole: one that is
/// inside out remains so, for an open surface has no inside. Turned triangles take their normals along, turned too if
/// they were against the new side.
/// @throws InvalidInput if no triangle has an area.
/// Cost: O(n log n).
[[nodiscard]] RepairedMesh repair_mesh(Mesh mesh);

}  // namespace patinate
