/// \file
/// Where a photograph shows a color chart.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "capture/chart/chart_table.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Where a chart lies, or why it cannot be used.
struct ChartPlace {
  /// Pixel centers of the photograph from places across the chart; nothing where there is a problem.
  std::optional<Eigen::Matrix3d> photo_from_chart = {};
  std::string problem = "";  ///< Problem, as the end of a sentence about the photograph; "" = none.
};

/// Even patches with four sides that stand in a grid of 6 x 4, in the one of its turns in which a 3 x 3 matrix brings
/// their colors to the table's. Mirrored turns are tried as well, and named. Also named is a chart of which a part lies
/// outside of the photograph, and one whose patches do not lie as those of a plane do.
/// @param linear  H x W x 3, linear light, finite. @param table  is_classic_layout(). @throws InvalidInput
/// Cost: O(H W), and some 0.3 s.
[[nodiscard]] ChartPlace find_chart(const ImageF& linear, const ChartTable& table);

/// The place of a chart whose corners are given: outer corners of its outermost patches, as the table's places count
/// them, (0, 0), (1, 0), (1, 1), (0, 1).
[[nodiscard]] ChartPlace place_chart(const std::array<Eigen::Vector2d, 4>& corners);

}  // namespace patinate::capture
