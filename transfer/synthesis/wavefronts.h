/// \file
/// An order of visiting texels that many threads can keep.
#pragma once

#include <vector>

#include "transfer/synthesis/levels.h"

namespace patinate::transfer {

/// Texels in groups: of two texels of which one is a neighbor of the other, the one that comes first in row order is in
/// an earlier group. Visiting group after group, each in any order, therefore gives what visiting row by row gives
/// [Lamport 1974, "The parallel execution of DO loops"].
[[nodiscard]] std::vector<std::vector<TexelId>> wavefronts(const DestinationLevel& destination);

}  // namespace patinate::transfer
