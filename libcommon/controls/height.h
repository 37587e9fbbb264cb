/// \file
/// How high a place lies: splash water, rising damp, snow lines.
#pragma once

#include <array>

#include "patinate/controls/control_map.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Position along `up` above the object's lowest point, mm. Range: from 0 to the object's height (1 mm if it has none).
/// @param up  Any length > 0. @throws InvalidInput if it has none. Exact.
[[nodiscard]] ControlMap height_map(const TexelMap& map, const std::array<double, 3>& up = {0, 1, 0},
                                    const RunControl& control = {});

}  // namespace patinate
