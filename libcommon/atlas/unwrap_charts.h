/// \file
/// Steps of unwrap(), 2: the surface cut into charts [Sander, Wood, Gortler, Snyder, Hoppe 2003, "Multi-chart geometry
/// images", sec. 3.1: Lloyd's iteration with paths whose cost is length times how far the surface turns from the
/// chart].
#pragma once

#include <vector>

#include "libcommon/atlas/unwrap_surface.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Chart of every triangle, from 0; -1 for those with is_point. Charts are connected over edges. All but specks keep
/// their normals within `max_normal_angle_deg` of the chart's axis; new seeds are set until nothing else is left.
[[nodiscard]] std::vector<int> grow_charts(const UnwrapSurface& surface, double max_normal_angle_deg,
                                           const RunControl& control);

/// Moves triangles that stick out into the chart around them, where the normal cone lets them, while that shortens
/// borders; a border on a crease counts a fifth.
void smooth_borders(const UnwrapSurface& surface, double max_normal_angle_deg, std::vector<int>& triangle_chart,
                    const RunControl& control = {});

/// Cuts a connected set of at least two triangles in two or more connected ones, each ascending.
class ChartSplitter {
 public:
  explicit ChartSplitter(const UnwrapSurface& surface);
  [[nodiscard]] std::vector<std::vector<int>> split(const std::vector<int>& triangles);

 private:
  const UnwrapSurface& surface_;
  std::vector<int> label_;  ///< Blocked everywhere between calls.
};

/// Unit mean normal of a set, weighted by area.
[[nodiscard]] Vec3 chart_axis(const UnwrapSurface& surface, const std::vector<int>& triangles);

/// Triangles per chart, ascending; empty charts are excluded.
[[nodiscard]] std::vector<std::vector<int>> triangles_by_chart(const std::vector<int>& triangle_chart);

}  // namespace patinate
