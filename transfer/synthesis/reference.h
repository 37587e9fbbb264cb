/// \file
/// Texture synthesis as the source describes it, one texel at a time: plain, and the measure of the fast one.
#pragma once

#include <span>

#include "patinate/transfer/transfer.h"
#include "transfer/synthesis/energy.h"

namespace patinate::transfer {

/// Searches, for each texel in row order, the whole window for the source pixel of least energy. The window's center is
/// the source pixel of similar control value (one of 64 tried) that lies nearest to the weighted mean position from
/// which the known neighbors came [Observing and Transferring Material Histories, sec. 4; docs/decisions/0003].
///
/// Exact, and pruned (window_search.h): about a hundred costs a texel and pass in place of 10,000. Texels that are not
/// neighbors are placed at the same time, in an order that row order cannot be told from. Same bits for any number of
/// threads and instruction set. @param seed  Chooses which similar pixels are tried.
[[nodiscard]] CoordinateMap synthesize_reference(const SourceLevel& source, const DestinationLevel& destination,
                                                 const Neighborhood& neighborhood, double coherence_share,
                                                 std::span<const double> control_weights, std::uint64_t seed,
                                                 const ReferenceOptions& options = {}, const RunControl& control = {});

}  // namespace patinate::transfer
