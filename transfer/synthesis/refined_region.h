/// \file
/// Parts of a level that are refined by themselves, so that an atlas of several tiles can be refined tile by tile:
/// the tiles, and the zones along their borders, in turn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "libcommon/atlas/texel_neighborhood.h"
#include "transfer/synthesis/tile_grid.h"

namespace patinate::transfer {

/// What windows of refinement stay inside. Nobody sees a texel of another region from a member: regions can be refined
/// in any order, or at once.
struct RefinedRegion {
  std::uint64_t index = 0;                   ///< Of random numbers.
  int width = 0;                             ///< Of the level.
  std::vector<TexelRect> rects = {};         ///< That hold the region; they do not overlap.
  std::vector<std::uint8_t> is_member = {};  ///< By texel of the rectangles, one after the other; empty: all are.

  [[nodiscard]] std::size_t num_texels() const;
  /// Of the rectangles' texels; none if it lies in none of them.
  [[nodiscard]] std::optional<std::size_t> index_of(TexelId texel) const;
  [[nodiscard]] bool has(TexelId texel) const {
    if (is_member.empty()) return true;
    const std::optional<std::size_t> at = index_of(texel);
    return at && is_member[*at] != 0;
  }
};

/// @param neighbors  Of the tile's texels at least.
[[nodiscard]] RefinedRegion region_of_tile(const TexelMap& map, const TileGrid& grid, std::size_t level, int tile,
                                           const TexelNeighborhood& neighbors);

/// A texel near another tile.
struct BorderTexel {
  TexelId texel = -1;
  std::int64_t other = -1;  ///< That tile; of several the one that is fewest texels away, then the lowest.
};
/// Those of a tile, ascending: from texel to texel over the surface at most `reach` are between them and the other one.
/// @param neighbors  Of the tile's texels at least.
[[nodiscard]] std::vector<BorderTexel> find_border_texels(const TexelMap& map, const TileGrid& grid, std::size_t level,
                                                          int tile, const TexelNeighborhood& neighbors, int reach);

/// Both sides of the border of two tiles.
struct BorderZone {
  int lower = 0, higher = 0;
  std::vector<TexelId> texels = {};  ///< Ascending.
};

/// The zones of a level: each border texel is in one.
class BorderZones {
 public:
  /// @param by_tile  As find_border_texels() gives them; must outlive this.
  BorderZones(const TileGrid& grid, std::size_t level, std::vector<std::span<const BorderTexel>> by_tile)
      : grid_(grid), level_(level), by_tile_(std::move(by_tile)) {}

  /// Those of a tile with higher ones.
  [[nodiscard]] std::vector<BorderZone> zones_of(int tile) const;
  /// @param neighbors  Of the zone's texels at least.
  [[nodiscard]] RefinedRegion region_of(const TexelMap& map, const BorderZone& zone,
                                        const TexelNeighborhood& neighbors) const;

 private:
  [[nodiscard]] int tile_of(TexelId texel) const;
  /// No texel of another zone.
  [[nodiscard]] bool is_free_for(const BorderZone& zone, TexelId texel) const;

  const TileGrid& grid_;
  std::size_t level_;
  std::vector<std::span<const BorderTexel>> by_tile_;
};

}  // namespace patinate::transfer
