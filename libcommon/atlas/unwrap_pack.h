/// \file
/// Steps of unwrap(), 5: flat charts placed on one square, as bitmaps that may lie in each other's bays and holes.
#pragma once

#include <vector>

#include "libcommon/atlas/unwrap_flatten.h"
#include "patinate/core/run_control.h"

namespace patinate {

struct PackedCharts {
  std::vector<FlatChart> charts;  ///< In the order given; points in [0, 1].
  double scale = 0.0;             ///< Atlas side lengths per unit of the flat charts.
};

/// Turns every chart to its smallest box and places all at one scale, the largest found, `gutter_texels` apart and half
/// of that from the atlas's edge. Charts are tried in four turns, larger ones first, each where it reaches least far.
/// @throws InvalidInput if there are more charts than the atlas has room for.
[[nodiscard]] PackedCharts pack_charts(std::vector<FlatChart> charts, int resolution, int gutter_texels,
                                       const RunControl& control);

}  // namespace patinate
