#include "transfer/tiles/tile_halo.h"

#include <algorithm>

namespace patinate::transfer {

namespace {

struct TexelPlace {
  int x, y;
};
TexelPlace place_of(const TexelMap& map, TexelId t) {
  return {static_cast<int>(t % map.width()), static_cast<int>(t / map.width())};
}

/// The covered texels around (x, y), whatever chart they are of.
template <class Visit>
void for_each_around(const TexelMap& map, int x, int y, const Visit& visit) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if ((dx == 0 && dy == 0) || !map.rect().contains(x + dx, y + dy)) continue;
      const TexelId t = TexelId{y + dy} * map.width() + x + dx;
      if (map.is_covered(t)) visit(t);
    }
  }
}

bool are_side_by_side(const TexelMap& map, TexelId a, TexelId b) {
  const TexelPlace p = place_of(map, a), q = place_of(map, b);
  return std::abs(p.x - q.x) <= 1 && std::abs(p.y - q.y) <= 1;
}

/// Grows a tile ring by ring.
class HaloFinder {
 public:
  HaloFinder(const TexelMap& map, const TexelRect& rect, const NeighborFinder& find, const StoredLinks& links,
             const RunControl& control)
      : map_(map), rect_(rect), find_(find), links_(links), control_(control) {
    halo_.sets = ZeroedVector<std::uint8_t>(static_cast<std::size_t>(map.num_texels()));
  }

  TileHalo find() {
    for (int y = rect_.y0; y < rect_.y1; ++y) {
      for (int x = rect_.x0; x < rect_.x1; ++x) {
        if (const TexelId t = TexelId{y} * map_.width() + x; map_.is_covered(t)) halo_.sets[t] = kSets;
      }
    }
    std::vector<TexelId> ring;
    for (int y = rect_.y0; y < rect_.y1; ++y) {
      const TexelId row = TexelId{y} * map_.width();
      const bool is_outer_row = y == rect_.y0 || y == rect_.y1 - 1;
      for (int x = rect_.x0; x < rect_.x1; ++x) {
        const bool is_outer = is_outer_row || x == rect_.x0 || x == rect_.x1 - 1;
        if (is_outer && map_.is_covered(row + x)) for_each_around(map_, x, y, [&](TexelId u) { add(u, kSets, ring); });
      }
      links_.for_each_source(row + rect_.x0, row + rect_.x1, [&](TexelId u) { add(u, kSets, ring); });
    }
    ring = grown(ring, kSets - 1, true);
    for (int sets = kSets - 2; sets > 0; --sets) ring = grown(ring, sets, false);
    for (const TexelId t : find_neighbors_of({{}, ring})) {
      if (halo_.sets[t] == 0) halo_.looked_at.push_back(t);
    }
    std::sort(halo_.looked_at.begin(), halo_.looked_at.end());
    halo_.looked_at.erase(std::unique(halo_.looked_at.begin(), halo_.looked_at.end()), halo_.looked_at.end());
    return std::move(halo_);
  }

 private:
  static constexpr std::uint8_t kSets = search_kernel::kInterleavedSets;

  void add(TexelId t, int sets, std::vector<TexelId>& ring) {
    std::uint8_t& mine = halo_.sets[t];
    if (mine != 0) return;
    mine = static_cast<std::uint8_t>(sets);
    ring.push_back(t);
    halo_.decided.push_back(t);
  }
  [[nodiscard]] std::vector<TexelId> find_neighbors_of(const TexelPart& part) const {
    control_.throw_if_stopped();
    const TexelNeighborhood neighborhood = find_(part);
    TexelNeighborhood::Cursor cursor(neighborhood);
    std::vector<TexelId> found;
    for (const TexelId t : neighborhood.band()) {
      for (const PixelNeighbor& n : cursor.at(t)) {
        if (n.texel >= 0 && halo_.sets[n.texel] == 0) found.push_back(n.texel);
      }
    }
    return found;
  }
  /// What the last ring looks at (with the tile itself, if asked for), and by whom it is looked at.
  std::vector<TexelId> grown(const std::vector<TexelId>& ring, int sets, bool with_tile) {
    std::vector<TexelId> next;
    for (const TexelId t : find_neighbors_of({with_tile ? rect_ : TexelRect{}, ring})) add(t, sets, next);
    for (const TexelId t : ring) {
      const TexelPlace p = place_of(map_, t);
      for_each_around(map_, p.x, p.y, [&](TexelId u) { add(u, sets, next); });
      links_.for_each_source(t, t + 1, [&](TexelId u) { add(u, sets, next); });
    }
    return next;
  }

  const TexelMap& map_;
  const TexelRect& rect_;
  const NeighborFinder& find_;
  const StoredLinks& links_;
  const RunControl& control_;
  TileHalo halo_;
};

}  // namespace

std::vector<TexelLink> find_links(const TexelMap& map, const TexelRect& rect, const NeighborFinder& find) {
  const TexelNeighborhood neighborhood = find({rect, {}});
  TexelNeighborhood::Cursor cursor(neighborhood);
  std::vector<TexelLink> links;
  for (const TexelId t : neighborhood.band()) {
    for (const PixelNeighbor& n : cursor.at(t).subspan(neighborhood.first_adjacent())) {
      if (n.texel >= 0 && !are_side_by_side(map, t, n.texel)) links.push_back({n.texel, t});
    }
  }
  std::sort(links.begin(), links.end());
  return links;
}

StoredLinks::StoredLinks(const std::filesystem::path& folder, std::size_t level, int num_tiles) {
  for (int i = 0; i < num_tiles; ++i) {
    files_.emplace_back(folder / tile_file::links(level, i));
    all_.push_back(files_.back().all<TexelLink>());
  }
}

TileHalo find_halo(const TexelMap& map, const TexelRect& rect, const NeighborFinder& find, const StoredLinks& links,
                   const RunControl& control) {
  return HaloFinder(map, rect, find, links, control).find();
}

std::vector<TexelId> find_rim(const TexelMap& map, const TexelPart& part, const NeighborFinder& find) {
  const TexelNeighborhood neighborhood = find(part);
  TexelNeighborhood::Cursor cursor(neighborhood);
  std::vector<TexelId> rim;
  for (const TexelId t : neighborhood.band()) {
    for (const PixelNeighbor& n : cursor.at(t)) {
      if (n.texel < 0) continue;
      const TexelPlace p = place_of(map, n.texel);
      if (!part.rect.contains(p.x, p.y) && !std::binary_search(part.others.begin(), part.others.end(), n.texel))
        rim.push_back(n.texel);
    }
  }
  std::sort(rim.begin(), rim.end());
  rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
  return rim;
}

}  // namespace patinate::transfer
