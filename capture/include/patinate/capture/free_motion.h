/// \file
/// Motions that a shape slides over itself by: what registration cannot determine.
#pragma once

#include <string>
#include <vector>

#include "patinate/geometry/rigid_transform.h"

namespace patinate::capture {

/// One motion that changes nothing.
struct FreeMotion {
  enum class Kind { Shift, Turn };
  Kind kind = Kind::Shift;
  Vec3 direction = Vec3(0, 0, 1);  ///< Unit: of the shift, or of the turn's axis.
  Vec3 point = Vec3::Zero();       ///< Turn: on the axis, the one nearest to the origin of the frame.
  double pitch = 0.0;              ///< Turn: shift along the axis per radian; 0 but for screws.
};
/// "shift along (0, 0, 1)", "turn about (0, 0, 1) through (10, 2, 0)".
[[nodiscard]] std::string text_of(const FreeMotion& motion);

/// Motions in the span of `directions` (columns: rotation, shift; 6 x k), as many as columns: pure shifts first, then
/// turns that are as free of shift as the span allows. A plane gives two shifts and a turn, a cylinder a shift and a
/// turn about its axis, a sphere three turns about its middle.
[[nodiscard]] std::vector<FreeMotion> free_motions(const Eigen::Matrix<double, 6, Eigen::Dynamic>& directions);

}  // namespace patinate::capture
