#include "transfer/synthesis/open_options.h"

#include <algorithm>

#include "transfer/synthesis/multi_level.h"

namespace patinate::transfer {

TransferOptions with_defaults(TransferOptions options, bool has_structure, bool is_library) {
  // Pixels are taken one by one: with less weight on the texture, one of exactly the right control is taken although
  // nothing around it fits, and lines get lost. In a library the control also says which history is meant.
  constexpr double kReferenceCoherence = 0.995;

  if (options.neighborhood_radius_px == 0) options.neighborhood_radius_px = has_structure ? 4 : 3;
  if (!options.coherence_share && options.method == TransferMethod::Reference && !is_library)
    options.coherence_share = kReferenceCoherence;
  if (!options.coherence_share) options.coherence_share = has_structure ? 0.85 : 0.65;
  if (!options.reference.first_coherence) options.reference.first_coherence = options.coherence_share;
  if (!options.multi_level.first_coherence) options.multi_level.first_coherence = has_structure ? 0.6 : kFirstCoherence;
  return options;
}

bool keeps_fractions(const TransferOptions& options, const HistoryFacts& history) {
  constexpr int kPixelsBeside = 2, kWidest_px = 65536;
  return options.method == TransferMethod::Fast && options.neighborhood_radius_px >= kPixelsBeside &&
         std::max(history.width, history.height) <= kWidest_px;
}

}  // namespace patinate::transfer
