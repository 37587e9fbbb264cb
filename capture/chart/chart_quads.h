/// \file
/// Even patches with four sides in a picture, and grids of them. Inside of the chart only.
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::capture {

/// An even patch whose border has four sides.
struct ChartQuad {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< Pixel centers are whole numbers.
  Eigen::Vector2d along = Eigen::Vector2d::Zero();   ///< Mean of two opposite sides, and of the other two.
  Eigen::Vector2d across = Eigen::Vector2d::Zero();
};

/// Quads by their column and row, counted from any of them.
using QuadGrid = std::map<std::pair<int, int>, ChartQuad>;

/// @param codes  H x W x 3, as a person sees them, in [0, 1].
[[nodiscard]] std::vector<ChartQuad> find_quads(const ImageF& codes);

/// Grids of evenly spaced quads of about one size, no larger than the chart, the largest first; at most a few, each
/// with other quads. Columns and rows begin at 0.
[[nodiscard]] std::vector<QuadGrid> find_grids(const std::vector<ChartQuad>& quads);

}  // namespace patinate::capture
