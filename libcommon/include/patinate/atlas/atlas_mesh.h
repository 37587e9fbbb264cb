/// \file
/// A mesh whose UVs lie in the tiles of an atlas, and its ways to and from one grid of texels.
#pragma once

#include <string>
#include <vector>

#include "patinate/atlas/sheet.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/atlas/uv_layout.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

/// A mesh and the squares that its UVs lie in.
struct AtlasMesh {
  Mesh mesh;  ///< UVs as a file holds them: those of a tile lie in the unit square at its origin.
  UvLayoutRule rule = UvLayoutRule::Square;
  std::vector<AtlasTile> tiles;    ///< At least one; shift = origin and scale = 1 once the UVs are brought in.
  std::vector<int> triangle_tile;  ///< Into tiles; as long as the mesh's triangles.
  bool is_unwrapped = false;
  std::vector<std::string> notes;  ///< What a user should know, each a sentence without subject's name.

  [[nodiscard]] std::vector<std::string> tile_names() const;
};

/// The UVs of a layout, brought into its tiles. @param layout  Of this mesh, with tiles.
[[nodiscard]] AtlasMesh atlas_mesh_of(Mesh mesh, UvLayout layout);

/// The UVs of a file that an AtlasMesh was written to: nothing is fitted or measured.
/// @param rule, names  Of the tiles; one "" for a square alone.
/// @throws InvalidInput if a triangle lies in none of the tiles.
[[nodiscard]] AtlasMesh read_back_atlas_mesh(Mesh mesh, UvLayoutRule rule, const std::vector<std::string>& names);

/// The mesh with UVs over the whole sheet in [0, 1], as TexelMap and renderers take it.
/// @param sheet  With as many tiles.
[[nodiscard]] Mesh sheet_mesh(const AtlasMesh& atlas, const Sheet& sheet);
/// The mesh with the UVs of every tile in [0, 1].
[[nodiscard]] Mesh unit_square_mesh(const AtlasMesh& atlas);

/// TexelMap over the sheet of all tiles of `resolution` x `resolution` texels.
[[nodiscard]] TexelMap make_texel_map(const AtlasMesh& atlas, int resolution, const RunControl& control = {});

}  // namespace patinate
