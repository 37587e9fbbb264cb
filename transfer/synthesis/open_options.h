/// \file
/// Options that were left open, and what they become.
#pragma once

#include "patinate/transfer/transfer.h"

namespace patinate::transfer {

/// With a coherence share on the finest and on the coarsest level, and a neighborhood. Pieces of a source with
/// structure must be large, and are chosen by a wider neighborhood; the refinement afterwards brings the control error
/// down again.
[[nodiscard]] TransferOptions with_defaults(TransferOptions options, bool has_structure);

}  // namespace patinate::transfer
