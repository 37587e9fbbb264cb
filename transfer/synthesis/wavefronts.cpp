#include "transfer/synthesis/wavefronts.h"

#include <algorithm>

namespace patinate::transfer {

std::vector<std::vector<TexelId>> wavefronts(const DestinationLevel& destination) {
  std::vector<std::int32_t> front(static_cast<std::size_t>(destination.map->num_texels()), 0);
  TexelNeighborhood::Cursor cursor(*destination.neighbors);
  std::vector<std::vector<TexelId>> fronts;
  for (TexelId t : destination.texels) {  // Ascending.
    const std::span<const PixelNeighbor> neighbors = cursor.at(t);
    std::int32_t& own = front[t];
    for (const PixelNeighbor& n : neighbors) {
      if (n.texel >= 0 && n.texel < t) own = std::max(own, front[n.texel] + 1);
    }
    for (const PixelNeighbor& n : neighbors) {  // Across seams a neighbor may not have this one as its own.
      if (n.texel > t) front[n.texel] = std::max(front[n.texel], own + 1);
    }
    if (fronts.size() <= static_cast<std::size_t>(own)) fronts.resize(static_cast<std::size_t>(own) + 1);
    fronts[own].push_back(t);
  }
  return fronts;
}

}  // namespace patinate::transfer
