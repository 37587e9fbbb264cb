/// \file
/// Builds the arrays of RayTracer.
#pragma once

#include <vector>

#include "simulation/tracing/ray_tracer.h"

namespace patinate::simulation {

struct Bvh {
  std::vector<BvhNode> nodes;
  std::vector<TriangleBlock> blocks;
};

using RoundedTriangle = std::array<std::array<float, 3>, 3>;  ///< [corner][axis].

/// Top down: the cheapest of 16 bins' borders along each axis by surface area [Wald 2007], down to four triangles, then
/// pairs of levels are joined. The same for the same triangles, always.
/// @param slack  All boxes are grown by this.
/// Cost: O(n log n); 0.1 us per triangle and level.
[[nodiscard]] Bvh build_bvh(const std::vector<RoundedTriangle>& triangles, float slack);

}  // namespace patinate::simulation
