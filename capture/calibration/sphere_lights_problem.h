/// \file
/// Inside lights_from_spheres(): the joint refinement. Ceres stays in its .cpp.
#pragma once

#include <optional>
#include <vector>

#include "patinate/capture/sphere_lights.h"

namespace patinate::capture {

/// Unknowns of the refinement, and their start.
struct SphereLightProblem {
  std::vector<Vec3> centers;  ///< Centers of the spheres.
  std::vector<Vec3> lights;   ///< Positions, or unit directions.
  std::vector<bool> is_near;  ///< One for each light.
  std::vector<bool> is_used;  ///< Lights that a sphere shows.
};
struct SphereLightSolution {
  bool has_converged = false;
  bool is_determined = false;                ///< Whether a covariance exists.
  std::vector<Eigen::Matrix3d> covariances;  ///< Covariances of the lights.
  std::vector<double> rms_px;                ///< Rms of each light's highlights.
};

/// Refines `problem` in place.
[[nodiscard]] SphereLightSolution refine_sphere_lights(const Camera& camera, const std::vector<MirrorSphere>& spheres,
                                                       const Highlights& highlights, const SphereLightOptions& options,
                                                       SphereLightProblem& start);

}  // namespace patinate::capture
