/// \file
/// Whether the borders of a flat chart cross each other.
#pragma once

#include <array>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// True where two of the segments meet other than in an end that both have by index.
/// @param segments  Pairs of indices into points.
/// Cost: O(segments) for segments of similar length (a grid); exact up to rounding.
[[nodiscard]] bool borders_cross(const std::vector<Vec2>& points, const std::vector<std::array<int, 2>>& segments);

}  // namespace patinate
