/// \file
/// Pixels of spots, and those around them.
#pragma once

#include <cstddef>
#include <vector>

namespace patinate::analysis {

inline constexpr int kFarRing_px = 6;  ///< So far around a spot its surroundings are seen.
inline constexpr int kFarFromSpots = 1000;

/// How far pixels are from the edge of their spot, in steps to one of eight neighbors.
struct SpotField {
  std::vector<int> labels;                       ///< Inside, and up to kFarRing_px outside of the nearest spot.
  std::vector<int> steps;                        ///< Outside 1, 2, ...; inside 0, -1, ... from the edge on.
  std::vector<std::vector<std::size_t>> pixels;  ///< By label, those above.
};

/// @param is_inside  W x H, not 0 = of a spot. Labels by connection over eight neighbors. Cost: linear.
[[nodiscard]] SpotField spot_field(const std::vector<char>& is_inside, int width, int height);

}  // namespace patinate::analysis
