/// \file
/// The order in which a chunk of gammatons is worked on: by the triangle that each was last at, so that neighbors on
/// the surface follow each other and find in the cache what the one before has read. Results do not depend on it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "simulation/tracing/gammatons.h"

namespace patinate::simulation {

/// Size of the chunks that work on `n` gammatons is split into: large enough for neighbors to meet, small enough for
/// some threads.
[[nodiscard]] inline std::int64_t chunk_of(std::int64_t n) { return std::clamp<std::int64_t>(n / 16, 1024, 32768); }

/// Indices [begin, end) by triangle, roughly, and then by index. @param num_triangles  Of the scene.
[[nodiscard]] inline std::vector<std::uint32_t> place_order(const Gammatons& gammatons, std::int64_t begin,
                                                            std::int64_t end, std::int64_t num_triangles) {
  int shift = 0;
  while ((num_triangles >> shift) > 8192) ++shift;
  std::vector<std::uint32_t> first(static_cast<std::size_t>((num_triangles >> shift) + 3), 0);
  const auto bucket = [&](std::int64_t i) {
    return static_cast<std::size_t>((gammatons.triangle[i] + 1) >> shift) + 1;
  };
  for (std::int64_t i = begin; i < end; ++i) ++first[bucket(i)];
  for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
  std::vector<std::uint32_t> order(static_cast<std::size_t>(end - begin));
  for (std::int64_t i = begin; i < end; ++i) order[first[bucket(i) - 1]++] = static_cast<std::uint32_t>(i);
  return order;
}

/// Asks for what is needed of a gammaton soon.
inline void prefetch(const Gammatons& gammatons, std::size_t i) {
#if defined(__GNUC__)
  __builtin_prefetch(&gammatons.state[i], 1);
  __builtin_prefetch(&gammatons.is_front[i], 1);
  __builtin_prefetch(&gammatons.b1[i], 1);
  __builtin_prefetch(&gammatons.b2[i], 1);
  __builtin_prefetch(&gammatons.position[i], 1);
  __builtin_prefetch(&gammatons.velocity[i], 1);
#else
  (void)gammatons;
  (void)i;
#endif
}

}  // namespace patinate::simulation
