/// \file
/// Degrees of freedom that a shape leaves unconstrained: what registration cannot determine.
#pragma once

#include <vector>

#include "patinate/capture/registration.h"

namespace patinate::capture {

/// Motions in the span of `directions` (columns: rotation, shift; 6 x k), as many as columns: pure shifts first, then
/// turns that are as free of shift as the span allows. A plane gives two shifts and a turn, a cylinder a shift and a
/// turn about its axis, a sphere three turns about its middle.
[[nodiscard]] std::vector<UnconstrainedDof> unconstrained_dofs(
    const Eigen::Matrix<double, 6, Eigen::Dynamic>& directions);

}  // namespace patinate::capture
