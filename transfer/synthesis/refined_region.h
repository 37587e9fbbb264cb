/// \file
/// Parts of a level that are refined by themselves, so that an atlas of several tiles can be refined tile by tile.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "libcommon/atlas/texel_neighborhood.h"
#include "transfer/synthesis/tile_grid.h"

namespace patinate::transfer {

/// A tile on a level, or a whole level of one. Windows of refinement stay inside it.
struct RefinedRegion {
  /// On a texel that has one of another region beside it, or is beside one: in even rounds texels of the region with
  /// the lower index move, and those of the other one are held; in odd rounds the other way. So a pair of texels over
  /// such a border is never changed from both sides at once.
  enum Beside : std::uint8_t { kLower = 1, kHigher = 2 };

  int index = 0;
  TexelRect rect;
  std::vector<std::uint8_t> beside = {};  ///< Flags of Beside by texel of the rectangle; empty: no other region.

  [[nodiscard]] static std::uint8_t held_in(int round) { return round % 2 == 0 ? kLower : kHigher; }
  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>((y - rect.y0) * rect.width() + x - rect.x0);
  }
  /// Notes that a texel of the region and one of another lie beside each other.
  void note(int x, int y, int other) { beside[at(x, y)] |= other < index ? kLower : kHigher; }
};

/// A tile by itself, from what its own texels have beside them. What other tiles' texels have beside them is missing:
/// who sees over a seam is not always seen.
/// @param neighbors  Of the tile's texels at least.
[[nodiscard]] RefinedRegion region_of_tile(const TexelMap& map, const TileGrid& grid, std::size_t level, int tile,
                                           const TexelNeighborhood& neighbors);
/// All tiles. @param grid  Null: the level is one region.
[[nodiscard]] std::vector<RefinedRegion> refined_regions(const TexelMap& map, const TileGrid* grid, std::size_t level,
                                                         const TexelNeighborhood& neighbors);

}  // namespace patinate::transfer
