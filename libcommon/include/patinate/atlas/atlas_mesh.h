/// \file
/// A mesh whose UVs are an atlas: how they make one (in one square, in UDIM tiles, in a square per material or node),
/// the mesh with its tiles, its ways to and from one grid of texels, and new UVs where its own will not do.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/atlas/sheet.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

/// The property of a triangle that selects its tile.
enum class UvLayoutRule { Square, Udim, Material, Node, Surface };

/// One square of texels.
struct AtlasTile {
  std::string name;  ///< "1001" of UDIM, a material's or node's name fit for a file; "" when there is but one square.
  Vec2 origin = Vec2::Zero();  ///< Where its square begins in the UVs that are written: whole numbers for UDIM, else 0.
  Vec2 shift = Vec2::Zero();   ///< (uv - shift) * scale is the place in its unit square of a UV of the file.
  double scale = 1.0;
};

/// UVs as an atlas.
struct UvLayout {
  UvLayoutRule rule = UvLayoutRule::Square;
  std::vector<AtlasTile> tiles;    ///< Empty when the UVs make no atlas at all.
  std::vector<int> triangle_tile;  ///< Into tiles; as long as the mesh's triangles.
  double overlap_share = 0.0;      ///< Share of the covered texels, in these tiles, that more than one triangle claims.
  double flat_share = 0.0;         ///< Share of the surface's area that has no area in UV.
  std::string problem;  ///< Why not every place has a texel of its own: "it has no UVs"; "" when every one has.
  std::string remark;   ///< Changes to the UVs that a user should know; "" = none.
};

inline constexpr double kMaxOverlap = 0.05;  ///< Largest acceptable share of the covered texels.
inline constexpr double kMaxFlat = 0.01;     ///< Largest acceptable share of the area.
inline constexpr double kMaxLean = 0.25;     ///< UVs that leave [0, 1] by no more are scaled into it.
inline constexpr int kMaxTiles = 100;

/// Finds the first that fits: all UVs in one square (leaning out by up to kMaxLean, or a whole number of squares
/// away); UDIM, where every triangle lies in one of the squares 1001 + u + 10 v, u in 0..9, v in 0..99; a square per
/// material, per node, or per surface, where they overlap together but not by themselves. Overlap is measured on 512 x
/// 512 texels per square.
///
/// With a problem, `tiles` holds the layout for those who insist (overlapping places share texels, flat ones have
/// none), or nothing when UVs are missing or spread over squares without order. Cost: O(triangles + texels).
[[nodiscard]] UvLayout find_uv_layout(const Mesh& mesh);

/// The same tiles of a mesh whose UVs were brought into them before: nothing is fitted or measured, and `tiles` is
/// empty where the rule does not suit the mesh. @param mesh  With a UV at every corner.
[[nodiscard]] UvLayout uv_layout_by_rule(const Mesh& mesh, UvLayoutRule rule);

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

enum class AtlasMethod {
  Auto,   ///< The mesh's UVs, unless find_uv_layout() has a problem with them.
  Uv,     ///< The mesh's UVs: places that share texels age alike.
  Unwrap  ///< New UVs by unwrap().
};
inline constexpr std::array<std::string_view, 3> kAtlasMethodNames{"auto", "uv", "unwrap"};

/// Makes any mesh ready for texels.
/// @param resolution  Texels along a tile: an unwrapped atlas keeps its gutters for it.
/// @throws InvalidInput for Uv when the mesh has no UVs, or UVs outside [0, 1] that are no tiles; what unwrap() throws.
[[nodiscard]] AtlasMesh make_atlas_mesh(Mesh mesh, AtlasMethod method, int resolution, const RunControl& control = {});

}  // namespace patinate
