/// \file
/// Poses of many scans that agree best with measured relative poses (Ceres inside).
#pragma once

#include <span>
#include <vector>

#include "patinate/geometry/rigid_transform.h"

namespace patinate::capture {

/// A measured relative pose.
struct PoseEdge {
  int target = 0;
  int source = 0;
  RigidTransform target_from_source;
  Matrix6 information = Matrix6::Zero();  ///< Information of (rotation, shift) on the target's side, about its origin;
                                          ///< free directions have 0.
};

/// Minimizes sum e^T information e, e = (rotation, shift) that is left of world_from_target^-1 world_from_source
/// target_from_source^-1, by Levenberg-Marquardt. @param world_from_scan  Start; `fixed` keeps its pose. @returns as
/// many poses; those without edges are the start's.
[[nodiscard]] std::vector<RigidTransform> solve_poses(std::span<const RigidTransform> world_from_scan,
                                                      std::span<const PoseEdge> edges, int fixed);

/// (rotation, shift) in one frame as another sees it: of exp(xi) in the frame of `b`, a_from_b exp(xi) a_from_b^-1 =
/// exp(adjoint(a_from_b) xi).
[[nodiscard]] Matrix6 adjoint(const RigidTransform& a_from_b);

/// Inverse of the normal matrix of solve_poses() in the world's frame: for every scan the covariance of (rotation,
/// shift) about the world's origin; 0 for `fixed`. Directions that nothing determines have 0.
[[nodiscard]] std::vector<Matrix6> pose_covariances(std::span<const RigidTransform> world_from_scan,
                                                    std::span<const PoseEdge> edges, int fixed);

}  // namespace patinate::capture
