/// \file
/// Inside lights_from_lambertian(): the joint refinement. Ceres stays in its .cpp.
#pragma once

#include <vector>

#include "capture/calibration/ceres_solve.h"
#include "patinate/capture/lambertian_lights.h"

namespace patinate::capture {

struct LambertianProblem {
  std::vector<Vec3> positions;
  std::vector<Vec3> strengths;  ///< albedo / pi * intensity / scale^2.
  Vec3 ambient = Vec3::Zero();
  Vec2 vignetting = Vec2::Zero();
  double scale_mm = 1.0;  ///< Brings strengths to the size of values.
};
struct LambertianSolution {
  bool has_converged = false;
  double sigma = 0.0;
  Information information;  ///< Position and strength of each light in turn, then ambient and vignetting where fitted.
  std::vector<double> rms;  ///< Of each light.
};

/// radius2[light][sample]: squared distance from the picture's middle, 1 at its corners. Refines `problem` in place.
[[nodiscard]] LambertianSolution refine_lambertian(const std::vector<std::vector<ShadedSample>>& samples,
                                                   const std::vector<std::vector<double>>& radius2,
                                                   const LambertianLightOptions& options, LambertianProblem& start);

}  // namespace patinate::capture
