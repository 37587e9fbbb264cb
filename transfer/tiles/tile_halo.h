/// \file
/// Which texels around a tile have to be known, and worked on along with it, so that a pass over the tile alone decides
/// as a pass over everything would.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <vector>

#include "libcommon/atlas/texel_neighborhood.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/tile_grid.h"
#include "transfer/tiles/tile_files.h"

namespace patinate::transfer {

/// Makes the neighborhood of a part of a level.
using NeighborFinder = std::function<TexelNeighborhood(const TexelPart& part)>;

/// Texels that have one beside them over a seam: who is looked at by whom is not who looks at whom.
[[nodiscard]] std::vector<TexelLink> find_links(const TexelMap& map, const TexelRect& rect, const NeighborFinder& find);

/// The links of all tiles on a level.
class StoredLinks {
 public:
  StoredLinks(const std::filesystem::path& folder, std::size_t level, int num_tiles);
  /// Calls visit(link) for those to one of [first, end).
  template <class Visit>
  void for_each(TexelId first, TexelId end, const Visit& visit) const {
    for (const auto& links : all_) {
      auto at = std::lower_bound(links.begin(), links.end(), TexelLink{first, -1});
      for (; at != links.end() && at->target < end; ++at) visit(*at);
    }
  }
  /// Calls visit(source) for the texels with such a link.
  template <class Visit>
  void for_each_source(TexelId first, TexelId end, const Visit& visit) const {
    for_each(first, end, [&](const TexelLink& link) { visit(link.source); });
  }

 private:
  std::vector<MappedFile> files_;
  std::vector<std::span<const TexelLink>> all_;
};

/// A pass is four turns. In the last, the tile's own texels are decided, and those beside which they lie (a change
/// there brings them their turn); in the turn before, also what those look at, and so on outward.
struct TileHalo {
  std::vector<TexelId> decided;     ///< Beyond the tile: in one turn at least.
  std::vector<TexelId> looked_at;   ///< And what they look at.
  ZeroedVector<std::uint8_t> sets;  ///< As LevelPart::sets.
};
[[nodiscard]] TileHalo find_halo(const TexelMap& map, const TexelRect& rect, const NeighborFinder& find,
                                 const StoredLinks& links, const RunControl& control);

/// Texels beyond a part that its own look at, ascending. @param part  Its others ascending.
[[nodiscard]] std::vector<TexelId> find_rim(const TexelMap& map, const TexelPart& part, const NeighborFinder& find);

}  // namespace patinate::transfer
