/// \file
/// Degrees of freedom that a shape leaves unconstrained, because it slides over itself along them: what registration
/// cannot determine.
#pragma once

#include <string>
#include <vector>

#include "patinate/geometry/rigid_transform.h"

namespace patinate::capture {

/// One rigid motion that changes nothing.
struct UnconstrainedDof {
  enum class Kind { Shift, Turn };
  Kind kind = Kind::Shift;
  Vec3 direction = Vec3(0, 0, 1);  ///< Unit: of the shift, or of the turn's axis.
  Vec3 point = Vec3::Zero();       ///< Turn: on the axis, the one nearest to the origin of the frame.
  double pitch = 0.0;              ///< Turn: shift along the axis per radian; 0 but for screws.
};
/// "shift along (0, 0, 1)", "turn about (0, 0, 1) through (10, 2, 0)".
[[nodiscard]] std::string text_of(const UnconstrainedDof& motion);

/// Motions in the span of `directions` (columns: rotation, shift; 6 x k), as many as columns: pure shifts first, then
/// turns that are as free of shift as the span allows. A plane gives two shifts and a turn, a cylinder a shift and a
/// turn about its axis, a sphere three turns about its middle.
[[nodiscard]] std::vector<UnconstrainedDof> unconstrained_dofs(
    const Eigen::Matrix<double, 6, Eigen::Dynamic>& directions);

}  // namespace patinate::capture
