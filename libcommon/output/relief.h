/// \file
/// A surface moved by its height map.
#pragma once

#include <vector>

#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate {

/// Edge of a texel on the surface: that of a square of the mean area, in mesh units; 0 if the UVs have no area.
[[nodiscard]] double mean_texel_edge(const Mesh& mesh, const ImageF& map);

enum class ReliefNormals {
  Kept,   ///< Those of the smooth surface: a map of normals tells the relief.
  Turned  ///< They follow the relief.
};

/// The mesh with equal positions as one: nothing can open between them. Positions, UVs and normals stay where they are.
[[nodiscard]] Mesh with_shared_positions(Mesh mesh);

/// The mesh refined to the texels of a map, as far as `max_triangles` allow.
/// @param mesh  With UVs and normals at every corner, and shared positions.
/// @param open  A value for every position; gets those of new ones, interpolated.
[[nodiscard]] Mesh refined_to_texels(Mesh mesh, const ImageF& map, int max_triangles, std::vector<float>& open);

/// The mesh moved by a height map along its normals. Every position moves once, by the mean over the UVs that it has:
/// what is closed stays closed. Where normals of a position cancel out (both sides of a thin sheet) nothing moves.
/// @param mesh    With UVs and normals at every corner, and shared positions.
/// @param height  1 channel, mesh units. @param factor  Of heights.
[[nodiscard]] Mesh displaced(Mesh mesh, const ImageF& height, double factor, ReliefNormals normals);

}  // namespace patinate
