/// \file
/// Lengths and positions that a scene or a browser names: so far as sums and squares of them are numbers.
#pragma once

#include "patinate/core/json.h"
#include "patinate/core/options.h"
#include "patinate/geometry/mesh.h"

namespace patinate::simulation {

inline constexpr double kFarthest_mm = 1e9;  ///< Limit of a coordinate or length: 1000 km.

/// Ranges of lengths in a unit of `mm_per_unit`: [0, kFarthest_mm] and (0, kFarthest_mm].
[[nodiscard]] Range up_to_farthest(double mm_per_unit);
[[nodiscard]] Range above_0_up_to_farthest(double mm_per_unit);
/// @returns position_mm. @throws IoError where it is farther than kFarthest_mm. @param json  Where it stands.
[[nodiscard]] Vec3 checked_position(const JsonReader& json, const Vec3& position_mm);
/// [x, y, z] in mm. @param mm_per_unit  Of the numbers. @throws IoError where it is farther than kFarthest_mm.
[[nodiscard]] Vec3 read_position(const JsonReader& json, double mm_per_unit);

}  // namespace patinate::simulation
