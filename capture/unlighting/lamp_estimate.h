/// \file
/// Strengths of lamps, and light from everywhere, that are not known. Inside of unlighting only.
#pragma once

#include "capture/unlighting/unlight_work.h"

namespace patinate::capture {

/// Result of estimate_lamps().
struct LampEstimate {
  bool is_converged = false;
  bool is_determined = true;  ///< False when some combination of strengths and ambient changes nothing that is seen.
  int num_steps = 0;
};

/// Gauss-Newton over the logarithms of the strengths (for each lamp and channel, geometric mean 1 in each channel: one
/// common factor belongs to the albedo) and the ambient irradiance of each channel, with albedo and normal of every
/// texel eliminated (Schur complement), on up to 8,000 texels spread over the surface. Between steps texels are fitted
/// again and shadows and highlights rejected. Sets work.strengths, work.ambient and work.noise_scale.
[[nodiscard]] LampEstimate estimate_lamps(UnlightWork& work, const RunControl& control);

}  // namespace patinate::capture
