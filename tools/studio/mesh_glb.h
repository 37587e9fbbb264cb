/// \file
/// Meshes for the browser: GLB without pictures.
#pragma once

#include <string>
#include <vector>

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
};
/// All of a mesh as one part.
[[nodiscard]] PartedMesh parted_mesh(Mesh mesh, const std::string& name);
/// The objects of a scene, where they stand; UVs over the whole atlas.
[[nodiscard]] PartedMesh parted_mesh(const simulation::Scene& scene);

/// The mesh cut to the texels of a texture, as far as 300,000 triangles allow: for a surface that heights move. Equal
/// positions become one; points stay. @param texels  Along each side of the texture. A mesh without UVs stays as it is.
[[nodiscard]] PartedMesh cut_to_texels(PartedMesh given, int texels);

/// A node for each part. Every triangle belongs to one at most.
/// @param mesh  With normals; UVs (v up) are flipped as glTF asks, and omitted when there are none.
/// @throws InvalidInput if a value is not finite.
[[nodiscard]] std::string mesh_glb(const PartedMesh& mesh, double meters_per_unit);

}  // namespace patinate::studio
