/// \file
/// Steps of unwrap(), 4: flat charts joined where one map serves both.
#pragma once

#include <vector>

#include "libcommon/atlas/unwrap_flatten.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Joins small charts first, each with the neighbor it shares most of its border with (creases count less), where
/// normals of the union keep to a cone of `max_normal_angle_deg` for 95 % of the area and it is flattened as Good.
/// @param charts  All Good; joined in place, order changed.
void merge_charts(const UnwrapSurface& surface, double max_normal_angle_deg, double max_stretch,
                  std::vector<FlatChart>& charts, const RunControl& control);

}  // namespace patinate
