/// \file
/// A random walk from texel to texel: how far what begins on one has spread after some steps. Its formulas stand in
/// spread_kernel.inl, which devices read too.
#pragma once

#include <vector>

#include "simulation/transport/splat.h"

namespace patinate::simulation {

using transfer_kernel::kVarianceOne;
using transfer_kernel::WalkLength;
/// The variance along an axis grows by twice the share with each step. @param size  The variance that the walk is to
/// have, texels^2, in 1/kVarianceOne; > 0.
using transfer_kernel::walk_length;

/// Appends where a walk from `texel` ends, and with what share of SplatShape::kWhole; the texel itself first. Over a
/// link goes what goes over one between whole texels, whatever the chart's edge leaves of them: as much mass each way
/// where texels hold mass in proportion to their areas, so that even rain stays even.
void walk_surface(const SurfaceAtlas& surface, TexelIndex texel, int size, std::vector<SplatPart>& parts);

}  // namespace patinate::simulation
