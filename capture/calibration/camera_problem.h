/// \file
/// Inside calibrate_camera(): the joint refinement. Ceres stays in its .cpp.
#pragma once

#include <array>
#include <vector>

#include "capture/calibration/ceres_solve.h"
#include "patinate/capture/camera_calibration.h"

namespace patinate::capture {

struct CameraProblem {
  std::array<double, 4> focal_center{};
  std::array<double, 5> lens{};
  std::vector<RigidTransform> poses;  ///< camera_from_points of each view.
};

struct CameraSolution {
  bool has_converged = false;
  double sigma_px = 0.0;
  Information information;  ///< Blocks: focal_center, the lens terms that are fitted, then the last view's turn and
                            ///< shift, then the others'.
  std::vector<std::vector<double>> residuals;  ///< Distance in pixels of each point of each view.
};

/// How many of k1 k2 p1 p2 k3 are fitted.
[[nodiscard]] int num_lens_terms(LensTerms lens);
/// Refines `problem` in place.
[[nodiscard]] CameraSolution refine_camera(const std::vector<const PointView*>& views,
                                           const CameraCalibrationOptions& options, CameraProblem& start);

}  // namespace patinate::capture
