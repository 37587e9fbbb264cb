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

/// @param mesh   With normals; UVs (v up) are flipped as glTF asks, and omitted when there are none.
/// @param parts  A node each. Every triangle belongs to one at most.
/// @throws InvalidInput if a value is not finite.
[[nodiscard]] std::string mesh_glb(const Mesh& mesh, const std::vector<MeshPart>& parts, double meters_per_unit);
/// All of it as one node.
[[nodiscard]] std::string mesh_glb(const Mesh& mesh, const std::string& name, double meters_per_unit);
/// A node for each object, where it stands; UVs over the whole atlas.
[[nodiscard]] std::string scene_glb(const simulation::Scene& scene);

}  // namespace patinate::studio
