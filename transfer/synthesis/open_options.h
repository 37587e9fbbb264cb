/// \file
/// Options that were left open, and what they become.
#pragma once

#include "patinate/transfer/transfer.h"

namespace patinate::transfer {

/// With a coherence share on the finest and on the coarsest level, and a neighborhood. Pieces of a source with
/// structure must be large, and are chosen by a wider neighborhood; the refinement afterwards brings the control error
/// down again.
[[nodiscard]] TransferOptions with_defaults(TransferOptions options, bool has_structure, bool is_library);

/// Whether results look between pixels: not the exhaustive search, which copies whole ones, not where the pixels around
/// may lie outside the mask, and not in sources so wide that a float does not know 1/256 pixel.
/// @param options  With a neighborhood.
[[nodiscard]] bool keeps_fractions(const TransferOptions& options, const HistoryFacts& history);

}  // namespace patinate::transfer
