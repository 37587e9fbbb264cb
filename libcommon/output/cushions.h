/// \file
/// Cushions in which small plants stand together: balls around hashed places in space, where they meet a surface.
#pragma once

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Where a place lies in its cushion.
struct CushionPlace {
  double depth = 0.0;           ///< 0 = outside or at the rim, 1 = in its middle.
  double height = 0.0;          ///< 0 = outside or at the rim, 1 = in the middle of the largest.
  Vec3 outward = Vec3::Zero();  ///< From the cushion's middle, over its radius: within the unit ball.
  double tone = 0.5;            ///< [0, 1), of the whole cushion.
};

/// The cushion that is highest at a place. A place's cushion does not depend on what grows there.
/// @param size  Diameter of the largest, > 0; the smallest have a third of it. One in each cube of that side.
[[nodiscard]] CushionPlace cushion_at(const Vec3& position, double size);

}  // namespace patinate
