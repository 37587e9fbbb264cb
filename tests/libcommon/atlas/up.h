/// \file
/// Where up is on planes that stand.
#pragma once

#include "patinate/geometry/mesh.h"

namespace patinate::testing_support {

inline const Vec3 kUp(0.0, 1.0, 0.0);

}  // namespace patinate::testing_support
