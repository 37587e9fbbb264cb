/// \file
/// What a synthesis gives: source coordinates, the controls that led it, and the figures that judge them.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::transfer {

/// Source pixel (y * width + x) per texel of the atlas; -1 = none (yet).
using CoordinateMap = std::vector<std::int32_t>;

inline constexpr int kControlSteps = 4095;  ///< Controls are integers in [0, 4095].

using ControlImage = Image<std::uint16_t>;  ///< H x W x C.

/// The figures that transfer.json reports.
struct EnergyReport {
  double energy = 0.0;              ///< a C + (1 - a) K, mean over texels.
  double coherence = 0.0;           ///< C, mean.
  double control_mismatch = 0.0;    ///< K, mean.
  double control_error_mean = 0.0;  ///< Mean |P - Q| of the first control, in [0, 1].
  double control_error_p95 = 0.0;
  double coherent_share =
      0.0;  ///< Adjacent texel pairs whose step in the source is that on the surface, to less than a pixel or texel.
  double used_share = 0.0;  ///< Usable source pixels that appear in the result.
};

}  // namespace patinate::transfer
