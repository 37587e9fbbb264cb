/// \file
/// Where the coordinates of a model are counted from in formats of single precision.
#pragma once

#include "patinate/geometry/mesh.h"

namespace patinate {

/// The origin; the model's middle where a coordinate exceeds two of its diagonals, as in maps' and the earth's
/// coordinates. Single precision rounds a coordinate c by up to 2^-24 |c|, so that distances keep to 1e-6 of the
/// model's size: 2 sqrt(3) 2^-24 x 2 sqrt(3) sizes = 7e-7. The writer moves what it writes back by it, in double
/// precision.
[[nodiscard]] Vec3 model_origin(const Mesh& mesh);

}  // namespace patinate
