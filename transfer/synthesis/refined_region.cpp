#include "transfer/synthesis/refined_region.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <numeric>

namespace patinate::transfer {

namespace {

struct TexelPlace {
  int x, y;
};
TexelPlace region_place_of(TexelId texel, int width) {
  return {static_cast<int>(texel % width), static_cast<int>(texel / width)};
}

/// Calls visit(texel) for the texels beside one, on the surface.
template <class Visit>
void for_each_beside(TexelId texel, TexelNeighborhood::Cursor& cursor, const TexelNeighborhood& neighbors,
                     const Visit& visit) {
  for (const PixelNeighbor& n : cursor.at(texel).subspan(neighbors.first_adjacent())) {
    if (n.texel >= 0 && n.texel != texel) visit(TexelId{n.texel});
  }
}

/// Calls visit(texel) for the covered texels of a rectangle, ascending.
template <class Visit>
void for_each_covered(const TexelMap& map, const TexelRect& rect, const Visit& visit) {
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      if (const TexelId t = TexelId{y} * map.width() + x; map.is_covered(t)) visit(t);
    }
  }
}

/// The least rectangle around texels; empty around none.
TexelRect bounds_of(std::span<const TexelId> texels, int width) {
  if (texels.empty()) return {};
  TexelRect bounds{std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), 0, 0};
  for (const TexelId t : texels) {
    const TexelPlace p = region_place_of(t, width);
    bounds = {std::min(bounds.x0, p.x), std::min(bounds.y0, p.y), std::max(bounds.x1, p.x + 1),
              std::max(bounds.y1, p.y + 1)};
  }
  return bounds;
}

}  // namespace

std::size_t RefinedRegion::num_texels() const {
  return std::accumulate(rects.begin(), rects.end(), std::size_t{0}, [](std::size_t sum, const TexelRect& r) {
    return sum + static_cast<std::size_t>(r.num_texels());
  });
}

std::optional<std::size_t> RefinedRegion::index_of(TexelId texel) const {
  const TexelPlace p = region_place_of(texel, width);
  std::size_t before = 0;
  for (const TexelRect& r : rects) {
    if (r.contains(p.x, p.y))
      return before + static_cast<std::size_t>(std::int64_t{p.y - r.y0} * r.width() + p.x - r.x0);
    before += static_cast<std::size_t>(r.num_texels());
  }
  return std::nullopt;
}

RefinedRegion region_of_tile(const TexelMap& map, const TileGrid& grid, std::size_t level, int tile,
                             const TexelNeighborhood& neighbors) {
  const TexelRect rect = grid.rect(level, tile);
  RefinedRegion region{.index = static_cast<std::uint64_t>(tile), .width = map.width(), .rects = {rect}};
  region.is_member.resize(region.num_texels());
  TexelNeighborhood::Cursor cursor(neighbors);
  for_each_covered(map, rect, [&](TexelId t) {
    bool is_inside = true;
    for_each_beside(t, cursor, neighbors, [&](TexelId n) { is_inside = is_inside && region.index_of(n); });
    region.is_member[*region.index_of(t)] = is_inside ? 1 : 0;
  });
  return region;
}

std::vector<BorderTexel> find_border_texels(const TexelMap& map, const TileGrid& grid, std::size_t level, int tile,
                                            const TexelNeighborhood& neighbors, int reach) {
  const TexelRect rect = grid.rect(level, tile);
  const RefinedRegion whole{.width = map.width(), .rects = {rect}};
  constexpr int kNone = std::numeric_limits<int>::max();
  std::vector<int> other(whole.num_texels(), kNone);
  std::vector<TexelId> found;
  TexelNeighborhood::Cursor cursor(neighbors);
  for_each_covered(map, rect, [&](TexelId t) {
    int& mine = other[*whole.index_of(t)];
    for_each_beside(t, cursor, neighbors, [&](TexelId n) {
      if (whole.index_of(n)) return;
      const TexelPlace p = region_place_of(n, map.width());
      mine = std::min(mine, grid.tile_of(level, p.x, p.y));
    });
    if (mine != kNone) found.push_back(t);
  });
  // Ring by ring. Within one, the lowest tile wins, whoever is looked at first.
  std::vector<TexelId> ring = found;
  for (int step = 0; step < reach && !ring.empty(); ++step) {
    std::vector<std::pair<TexelId, int>> next;
    for (const TexelId t : ring) {
      const int mine = other[*whole.index_of(t)];
      for_each_beside(t, cursor, neighbors, [&](TexelId n) {
        if (const auto at = whole.index_of(n); at && other[*at] == kNone) next.emplace_back(n, mine);
      });
    }
    ring.clear();
    for (const auto& [t, mine] : next) {
      int& its = other[*whole.index_of(t)];
      if (its == kNone) ring.push_back(t);
      its = std::min(its, mine);
    }
    found.insert(found.end(), ring.begin(), ring.end());
  }
  std::sort(found.begin(), found.end());
  std::vector<BorderTexel> border;
  border.reserve(found.size());
  for (const TexelId t : found) border.push_back({t, other[*whole.index_of(t)]});
  return border;
}

std::vector<BorderZone> BorderZones::zones_of(int tile) const {
  std::vector<BorderZone> zones;
  for (int other = 0; other < grid_.num_tiles(); ++other) zones.push_back({.lower = tile, .higher = other});
  for (const BorderTexel& b : by_tile_[tile]) {
    if (b.other > tile) zones[b.other].texels.push_back(b.texel);
  }
  for (int higher = tile + 1; higher < grid_.num_tiles(); ++higher) {
    for (const BorderTexel& b : by_tile_[higher]) {
      if (b.other == tile) zones[higher].texels.push_back(b.texel);
    }
  }
  std::erase_if(zones, [](const BorderZone& z) { return z.texels.empty(); });
  for (BorderZone& z : zones) std::sort(z.texels.begin(), z.texels.end());
  return zones;
}

RefinedRegion BorderZones::region_of(const TexelMap& map, const BorderZone& zone,
                                     const TexelNeighborhood& neighbors) const {
  const auto num_tiles = static_cast<std::uint64_t>(grid_.num_tiles());
  RefinedRegion region{
      .index = num_tiles * (1 + static_cast<std::uint64_t>(zone.lower)) + static_cast<std::uint64_t>(zone.higher),
      .width = map.width()};
  for (const int tile : {zone.lower, zone.higher}) {
    std::vector<TexelId> side;
    std::copy_if(zone.texels.begin(), zone.texels.end(), std::back_inserter(side),
                 [&](TexelId t) { return tile_of(t) == tile; });
    region.rects.push_back(bounds_of(side, map.width()));
  }
  region.is_member.resize(region.num_texels());
  TexelNeighborhood::Cursor cursor(neighbors);
  for (const TexelId t : zone.texels) {
    bool is_inside = true;
    for_each_beside(t, cursor, neighbors, [&](TexelId n) { is_inside = is_inside && is_free_for(zone, n); });
    region.is_member[*region.index_of(t)] = is_inside ? 1 : 0;
  }
  return region;
}

int BorderZones::tile_of(TexelId texel) const {
  const TexelPlace p = region_place_of(texel, grid_.width(level_));
  return grid_.tile_of(level_, p.x, p.y);
}

bool BorderZones::is_free_for(const BorderZone& zone, TexelId texel) const {
  const int tile = tile_of(texel);
  const auto& border = by_tile_[tile];
  const auto at = std::lower_bound(border.begin(), border.end(), texel,
                                   [](const BorderTexel& b, TexelId t) { return b.texel < t; });
  if (at == border.end() || at->texel != texel) return true;
  const int other = static_cast<int>(at->other);
  return std::min(tile, other) == zone.lower && std::max(tile, other) == zone.higher;
}

}  // namespace patinate::transfer
