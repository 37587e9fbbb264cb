#include "transfer/synthesis/open_options.h"

#include "transfer/synthesis/multi_level.h"

namespace patinate::transfer {

TransferOptions with_defaults(TransferOptions options, bool has_structure) {
  if (options.neighborhood_radius_px == 0) options.neighborhood_radius_px = has_structure ? 4 : 3;
  if (!options.coherence_share) options.coherence_share = has_structure ? 0.85 : 0.65;
  if (!options.multi_level.first_coherence) options.multi_level.first_coherence = has_structure ? 0.6 : kFirstCoherence;
  return options;
}

}  // namespace patinate::transfer
