#include "transfer/synthesis/refined_region.h"

namespace patinate::transfer {

namespace {

/// Calls visit(x, y, other) for the texels of a tile and those of other tiles that they have beside them, on the
/// surface or in the atlas.
template <class Visit>
void for_each_beside(const TexelMap& map, const TexelRect& rect, const TexelNeighborhood& neighbors,
                     const Visit& visit) {
  TexelNeighborhood::Cursor cursor(neighbors);
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      const TexelId t = TexelId{y} * map.width() + x;
      if (!map.is_covered(t)) continue;
      for (const PixelNeighbor& n : cursor.at(t).subspan(neighbors.first_adjacent())) {
        if (n.texel < 0) continue;
        const int nx = static_cast<int>(n.texel % map.width()), ny = static_cast<int>(n.texel / map.width());
        if (!rect.contains(nx, ny)) visit(x, y, n.texel);
      }
      if (x > rect.x0 && x + 1 < rect.x1 && y > rect.y0 && y + 1 < rect.y1) continue;
      for (int ny = y - 1; ny <= y + 1; ++ny) {
        for (int nx = x - 1; nx <= x + 1; ++nx) {
          if (rect.contains(nx, ny) || !map.rect().contains(nx, ny)) continue;
          if (const TexelId n = TexelId{ny} * map.width() + nx; map.is_covered(n)) visit(x, y, n);
        }
      }
    }
  }
}

RefinedRegion unmarked(const TileGrid& grid, std::size_t level, int tile) {
  const TexelRect rect = grid.rect(level, tile);
  return {
      .index = tile, .rect = rect, .beside = std::vector<std::uint8_t>(static_cast<std::size_t>(rect.num_texels()))};
}

}  // namespace

RefinedRegion region_of_tile(const TexelMap& map, const TileGrid& grid, std::size_t level, int tile,
                             const TexelNeighborhood& neighbors) {
  RefinedRegion region = unmarked(grid, level, tile);
  for_each_beside(map, region.rect, neighbors, [&](int x, int y, TexelId other) {
    region.note(x, y,
                grid.tile_of(level, static_cast<int>(other % map.width()), static_cast<int>(other / map.width())));
  });
  return region;
}

std::vector<RefinedRegion> refined_regions(const TexelMap& map, const TileGrid* grid, std::size_t level,
                                           const TexelNeighborhood& neighbors) {
  if (grid == nullptr) return {{.rect = map.rect()}};
  std::vector<RefinedRegion> regions;
  for (int tile = 0; tile < grid->num_tiles(); ++tile) regions.push_back(unmarked(*grid, level, tile));
  for (RefinedRegion& region : regions) {
    for_each_beside(map, region.rect, neighbors, [&](int x, int y, TexelId t) {
      const int ox = static_cast<int>(t % map.width()), oy = static_cast<int>(t / map.width());
      RefinedRegion& other = regions[static_cast<std::size_t>(grid->tile_of(level, ox, oy))];
      region.note(x, y, other.index);
      other.note(ox, oy, region.index);
    });
  }
  return regions;
}

}  // namespace patinate::transfer
