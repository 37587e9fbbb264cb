#include "capture/calibration/camera_problem.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>

#include "capture/calibration/brown_projection.h"

namespace patinate::capture {

namespace {

constexpr double kLeastSigmaPx = 1e-7;  ///< Exact pixels have no scale of their own.
constexpr int kPixelRounds = 3;

/// A point turned by the start's rotation already: the parameters are a small turn and the whole shift.
struct PixelError {
  Vec3 turned;
  Vec2 pixel;

  template <class T>
  bool operator()(const T* focal_center, const T* lens, const T* turn, const T* shift, T* error) const {
    const T point[3] = {T(turned[0]), T(turned[1]), T(turned[2])};
    T in_camera[3];
    ceres::AngleAxisRotatePoint(turn, point, in_camera);
    for (int i = 0; i < 3; ++i) in_camera[i] += shift[i];
    if (!(in_camera[2] > T(0.0))) return false;
    project_brown(focal_center, lens, in_camera, error);
    error[0] -= T(pixel[0]);
    error[1] -= T(pixel[1]);
    return true;
  }
};

struct Pose {
  std::array<double, 3> turn{};
  std::array<double, 3> shift{};
};

/// One problem over `poses`; losses of `huber_px`, none when it is 0.
void build(ceres::Problem& problem, const std::vector<const PointView*>& views, const CameraProblem& start,
           double huber_px, LensTerms lens, std::array<double, 4>& focal_center, std::array<double, 5>& lens_numbers,
           std::vector<Pose>& poses) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t i = 0; i < views[v]->pixels.size(); ++i) {
      auto* error = new PixelError{start.poses[v].rotation * views[v]->points_mm[i], views[v]->pixels[i]};
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PixelError, 2, 4, 5, 3, 3>(error),
                               huber_px > 0 ? new ceres::HuberLoss(huber_px) : nullptr, focal_center.data(),
                               lens_numbers.data(), poses[v].turn.data(), poses[v].shift.data());
    }
  }
  const int fitted = num_lens_terms(lens);
  if (fitted == 0) {
    problem.SetParameterBlockConstant(lens_numbers.data());
  } else if (fitted < 5) {
    std::vector<int> fixed;
    for (int i = fitted; i < 5; ++i) fixed.push_back(i);
    problem.SetManifold(lens_numbers.data(), new ceres::SubsetManifold(5, fixed));
  }
}

}  // namespace

int num_lens_terms(LensTerms lens) {
  constexpr std::array<int, 5> kNumTerms{0, 1, 2, 4, 5};
  return kNumTerms[static_cast<std::size_t>(lens)];
}

CameraSolution refine_camera(const std::vector<const PointView*>& views, const CameraCalibrationOptions& options,
                             CameraProblem& start) {
  CameraSolution solution;
  double huber_px = 0.0;
  for (int round = 0; round <= kPixelRounds; ++round) {
    std::vector<Pose> poses(views.size());
    for (std::size_t v = 0; v < views.size(); ++v) {
      for (std::size_t i = 0; i < 3; ++i) poses[v].shift[i] = start.poses[v].translation[static_cast<Eigen::Index>(i)];
    }
    ceres::Problem problem;
    build(problem, views, start, huber_px, options.lens, start.focal_center, start.lens, poses);
    solution.has_converged = solve_quietly(problem).has_converged;

    const std::vector<double> residuals = residuals_without_loss(problem);
    const double typical = std::max(kLeastSigmaPx, robust_sigma(residuals));
    huber_px = options.huber_sigmas * typical;
    if (round == kPixelRounds) {
      std::vector<double*> blocks{start.focal_center.data()};
      if (num_lens_terms(options.lens) > 0) blocks.push_back(start.lens.data());
      for (std::size_t v = views.size(); v-- > 0;)
        blocks.push_back(poses[v].turn.data()), blocks.push_back(poses[v].shift.data());
      solution.information = information_of(problem, blocks);
      double squares = 0.0;
      int num_near = 0;
      for (const double r : residuals) {
        if (std::abs(r) <= huber_px) squares += r * r, ++num_near;
      }
      solution.sigma_px = std::sqrt(squares / std::max(1, num_near - solution.information.num_parameters));
      std::size_t at = 0;
      for (const PointView* view : views) {
        solution.residuals.emplace_back();
        for (std::size_t i = 0; i < view->pixels.size(); ++i, at += 2)
          solution.residuals.back().push_back(std::hypot(residuals[at], residuals[at + 1]));
      }
    }
    for (std::size_t v = 0; v < views.size(); ++v) {
      start.poses[v].rotation =
          rotation_of(Vec3(poses[v].turn[0], poses[v].turn[1], poses[v].turn[2])) * start.poses[v].rotation;
      start.poses[v].translation = {poses[v].shift[0], poses[v].shift[1], poses[v].shift[2]};
    }
  }
  return solution;
}

}  // namespace patinate::capture
