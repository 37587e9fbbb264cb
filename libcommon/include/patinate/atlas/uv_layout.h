/// \file
/// How the UVs of a mesh make an atlas: in one square, in UDIM tiles, in a square per material or node, or not at all.
#pragma once

#include <string>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// What tells which tile a triangle belongs to.
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
  double overlap_share = 0.0;      ///< Of the covered texels, those that more than one triangle claims, in these tiles.
  double flat_share = 0.0;         ///< Of the surface's area, what has no area in UV.
  std::string problem;  ///< Why not every place has a texel of its own: "it has no UVs"; "" when every one has.
  std::string remark;   ///< What was done to the UVs that one should know; "" = nothing.
};

inline constexpr double kMostOverlap = 0.05;  ///< Of the covered texels: more is a problem.
inline constexpr double kMostFlat = 0.01;     ///< Of the area: more is a problem.
inline constexpr double kMostLean = 0.25;     ///< UVs that leave [0, 1] by no more are scaled into it.
inline constexpr int kMaxTiles = 100;

/// Finds the first that fits: all UVs in one square (leaning out by up to kMostLean, or a whole number of squares
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

}  // namespace patinate
