/// \file
/// A camera from photographs of a known target, and where it stands in scanner coordinates from points that the scanner
/// and the camera both see.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/camera.h"
#include "patinate/geometry/rigid_transform.h"

namespace patinate::capture {

/// Points of one frame and the pixels at which one photograph shows them.
struct PointView {
  std::vector<Vec3> points_mm;  ///< In the target's frame (z = 0 for a flat one), or in the scanner's.
  std::vector<Vec2> pixels;     ///< One pixel for each point.
  std::string name;             ///< For errors and reports.
};

/// Lens terms that are fitted; the others are 0.
enum class LensTerms { None, K1, K1K2, K1K2P1P2, All };

struct CameraCalibrationOptions {
  LensTerms lens = LensTerms::K1K2P1P2;  ///< k3 is rarely determined by a flat target.
  double huber_sigmas = 3.0;             ///< Points farther off weigh less; > 0.
  double max_focal_sd = 0.1;  ///< A focal length known worse than this share of it is reported as not determined; > 0.
};
void describe(OptionVisitor& v, CameraCalibrationOptions& o);

enum class CalibrationStatus {
  Converged,
  Undetermined,  ///< The views leave a parameter open: all frontal, all alike, too few; `weakest` names it.
  IterationLimit,
};
[[nodiscard]] std::string calibration_status_text(CalibrationStatus status);

/// fx fy cx cy k1 k2 p1 p2 k3, then the pose in the scanner's frame: a turn about the camera's axes (radians) and a
/// shift (mm).
inline constexpr int kNumCameraNumbers = 15;
[[nodiscard]] const char* camera_number_name(int index);

struct CameraCalibration {
  CalibrationStatus status = CalibrationStatus::Undetermined;
  CameraParameters
      camera;  ///< Its pose is that of the scanner's frame; without scanner points, of the first view's target.
  bool has_scanner_pose = false;
  Eigen::Matrix<double, kNumCameraNumbers, kNumCameraNumbers>
      covariance;  ///< Covariance of the camera numbers above; 0 for numbers that were not fitted or are undetermined.
  std::string weakest;    ///< The number that is known worst, e.g. "fx".
  double sigma_px = 0.0;  ///< Standard deviation of one pixel coordinate, from the residuals.
  double rms_px = 0.0;    ///< Distance, over all views.
  struct View {
    std::string name;
    RigidTransform camera_from_target;
    double rms_px = 0.0;
    double max_px = 0.0;
    int num_points = 0;
    int num_outliers = 0;  ///< Farther off than huber_sigmas.
  };
  std::vector<View> views;  ///< Targets in the order given, then the scanner's.
};

/// Every view starts with OpenCV's SQPnP at the focal length, of a series from 0.3 to 20 times the picture's larger
/// side, that fits best; then Ceres refines intrinsics, lens and all poses together on the distances in pixels (Huber,
/// its scale from the residuals' median, three rounds). The covariance is sigma^2 (J^T J)^-1.
/// @param targets  Views of targets; may be empty when the scanner's points are at least 6 and not on a plane.
/// @param scanner  Points in scanner coordinates seen by the same camera; empty: no pose. At least 3, not on a line.
/// @throws InvalidInput naming the view: fewer than 4 points (3 of the scanner), points on a line, sizes that differ,
/// numbers that are not finite, or fewer numbers than unknowns.
[[nodiscard]] CameraCalibration calibrate_camera(int width, int height, const std::vector<PointView>& targets,
                                                 const PointView& scanner, const CameraCalibrationOptions& options = {},
                                                 const RunControl& control = {});

}  // namespace patinate::capture
