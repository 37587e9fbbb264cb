/// \file
/// A random walk from texel to texel: how far what begins on one has spread after some steps.
#pragma once

#include <vector>

#include "simulation/transport/splat.h"

namespace patinate::simulation {

inline constexpr int kVarianceOne = 64;

/// Steps of one kind: `share` goes to each of four neighbors, the rest stays. The variance along an axis grows by twice
/// that with each step.
struct WalkLength {
  int num_steps = 0;
  double share = 0.0;
};
/// @param size  The variance that it is to have, texels^2, in 1/kVarianceOne; > 0.
[[nodiscard]] WalkLength walk_length(int size);
/// Of the middle's share per area: texels with less are left out, beyond 2.6 standard deviations. Short walks keep all.
[[nodiscard]] double least_of(const WalkLength& walk);

/// Appends where a walk from `texel` ends, and with what share of SplatShape::kWhole; the texel itself first. Over a
/// link goes what goes over one between whole texels, whatever the chart's edge leaves of them: as much mass each way
/// where texels hold mass in proportion to their areas, so that even rain stays even.
void walk_surface(const SurfaceAtlas& surface, TexelIndex texel, int size, std::vector<SplatPart>& parts);

}  // namespace patinate::simulation
