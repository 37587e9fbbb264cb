#include "transfer/synthesis/wavefronts.h"

#include <algorithm>

namespace patinate {

std::vector<std::vector<TexelId>> wavefronts(const DestinationLevel& destination) {
  std::vector<std::int32_t> front(static_cast<std::size_t>(destination.map->num_texels()), 0);
  std::vector<TexelId> neighbors(destination.neighbors->size());
  std::vector<std::vector<TexelId>> fronts;
  for (TexelId t : destination.texels) {  // Ascending.
    destination.neighbors->gather(t, neighbors);
    std::int32_t& own = front[static_cast<std::size_t>(t)];
    for (TexelId n : neighbors) {
      if (n >= 0 && n < t) own = std::max(own, front[static_cast<std::size_t>(n)] + 1);
    }
    for (TexelId n : neighbors) {  // Across seams a neighbour may not have this one as its own.
      if (n > t) front[static_cast<std::size_t>(n)] = std::max(front[static_cast<std::size_t>(n)], own + 1);
    }
    if (fronts.size() <= static_cast<std::size_t>(own)) fronts.resize(static_cast<std::size_t>(own) + 1);
    fronts[static_cast<std::size_t>(own)].push_back(t);
  }
  return fronts;
}

}  // namespace patinate
