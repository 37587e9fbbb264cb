/// \file
/// For every source pixel the few others that look most like it: the candidates of k-coherence search [Tong et al.
/// 2002].
#pragma once

#include <array>
#include <vector>

#include "transfer/synthesis/levels.h"

namespace patinate::transfer {

/// k of k-coherence search [Tong et al. 2002], docs/algorithms/synthesis.md.
inline constexpr int kNumSimilar = 3;

/// Per pixel of a level: indices of its most similar usable pixels, at least 5 px away, nearest first; -1 = none.
using SimilarPixels = std::vector<std::array<std::int32_t, kNumSimilar>>;

/// Nearest neighbors, at most 2.3 times as far as the exact ones (FLANN, a single k-d tree), in the eight leading
/// components of the appearance around a pixel, 2 px to all sides, and in the control; up to 65,536 pixels, evenly
/// chosen, are searched. Deterministic for any number of threads.
[[nodiscard]] SimilarPixels find_similar_pixels(const SourceLevel& source, const RunControl& control = {});

/// Similar pixels of the next finer level, from the coarser one's: pixel p is similar to where p's parent's similar
/// pixels lead.
[[nodiscard]] SimilarPixels refine_similar_pixels(const SimilarPixels& coarse, const SourceLevel& coarse_source,
                                                  const SourceLevel& fine_source);

}  // namespace patinate::transfer
