/// \file
/// Classes of color. Inside of capture only.
#pragma once

#include <cstddef>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate::capture {

inline constexpr double kMinColorSpread = 0.012;  ///< Spread of colors of one class: noise alone.

struct ColorClusters {
  std::vector<Vec3> centers;
  std::vector<std::size_t> of;  ///< One of them for each color.
};

/// Far from each other, one after the other, then means [Lloyd 1982], until none is farther than twice
/// kMinColorSpread from its own; deterministic.
/// @param colors  Not empty. @param max_count  >= 1.
[[nodiscard]] ColorClusters color_clusters(const std::vector<Vec3>& colors, std::size_t max_count);

}  // namespace patinate::capture
