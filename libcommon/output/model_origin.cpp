#include "libcommon/output/model_origin.h"

#include <algorithm>

namespace patinate {

Vec3 model_origin(const Mesh& mesh) {
  constexpr double kFarthest = 2.0;  // Diagonals.
  const Box box = bounding_box(mesh);
  const double farthest = std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
  return farthest > kFarthest * box.diagonal() ? box.center() : Vec3(Vec3::Zero());
}

}  // namespace patinate
