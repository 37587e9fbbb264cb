/// \file
/// Meshes for the browser: GLB without pictures.
#pragma once

#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/simulation/scene.h"

namespace patinate::studio {

/// One node of the GLB.
struct MeshPart {
  std::string name;
  std::vector<int> triangles;  ///< Triangles of the mesh.
  std::vector<Vec3> points;    ///< Without a surface, in the mesh's unit; where there are no triangles.
};

/// A mesh and its parts.
struct PartedMesh {
  Mesh mesh;
  std::vector<MeshPart> parts;
  std::vector<float> open = {};  ///< Ambient visibility of every position, [0, 1]; empty = not known.
};
/// All of a mesh as one part.
[[nodiscard]] PartedMesh parted_mesh(Mesh mesh, const std::string& name);
/// The objects of a scene, where they stand; UVs over the whole atlas.
[[nodiscard]] PartedMesh parted_mesh(const simulation::Scene& scene);

enum class LookDetail {
  Light,  ///< Edges short enough for ambient light, which is interpolated.
  Relief  ///< As short as texels, as far as 300,000 triangles allow: for a surface that heights move.
};
/// The mesh as `render` lights it: refined, equal positions as one, with ambient visibility. Points stay.
/// @param texels  Along each side of the texture, for Relief.
[[nodiscard]] PartedMesh lit_mesh(PartedMesh given, LookDetail detail, int texels, const RunControl& control);

/// A node for each part. Every triangle belongs to one at most. 1 - ambient visibility becomes the attribute `_HIDDEN`.
/// @param mesh  With normals; UVs (v up) are flipped as glTF asks, and omitted when there are none.
/// @throws InvalidInput if a value is not finite.
[[nodiscard]] std::string mesh_glb(const PartedMesh& mesh, double meters_per_unit);

}  // namespace patinate::studio
