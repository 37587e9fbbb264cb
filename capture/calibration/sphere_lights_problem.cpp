#include "capture/calibration/sphere_lights_problem.h"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "capture/calibration/brown_projection.h"
#include "capture/calibration/ceres_solve.h"

namespace patinate::capture {

namespace {

/// A camera's numbers as plain arrays.
struct FixedCamera {
  explicit FixedCamera(const Camera& camera) : center(camera.center()), rotation(camera.parameters().rotation) {
    const CameraParameters& p = camera.parameters();
    focal_center = {p.fx, p.fy, p.cx, p.cy};
    lens = p.distortion;
  }
  Vec3 center;
  Eigen::Matrix3d rotation;
  std::array<double, 4> focal_center;
  std::array<double, 5> lens;
};

template <class T>
using Vec3T = Eigen::Matrix<T, 3, 1>;

/// Where a light is seen in a mirror sphere, Alhazen's problem: the normal there halves the angle between camera and
/// light. The fixed point n <- half vector at center + radius n; each round brings it nearer by a factor of about
/// radius / distance.
struct HighlightError {
  const FixedCamera* camera;
  Vec2 pixel;
  double radius;
  double sigma;
  bool is_near;
  Vec3 normal;  ///< Near the solution.

  template <class T>
  bool operator()(const T* center_numbers, const T* light_numbers, T* error) const {
    const Eigen::Map<const Vec3T<T>> center(center_numbers), light(light_numbers);
    const Vec3T<T> eye = camera->center.cast<T>() - center;
    Vec3T<T> n = normal.cast<T>();
    constexpr int kRounds = 40;  // Iterations of the fixed point; each divides the error by about distance / R.
    for (int i = 0; i < kRounds; ++i) {
      const Vec3T<T> point = T(radius) * n;
      const Vec3T<T> to_light = is_near ? Vec3T<T>((light - center - point).normalized()) : Vec3T<T>(light);
      n = ((eye - point).normalized() + to_light).normalized();
    }
    const Vec3T<T> in_camera = camera->rotation.cast<T>() * Vec3T<T>(T(radius) * n - eye);
    if (!(in_camera[2] > T(0.0))) return false;
    T seen[2];
    project_brown(camera->focal_center.data(), camera->lens.data(), in_camera.data(), seen);
    error[0] = (seen[0] - T(pixel[0])) / T(sigma);
    error[1] = (seen[1] - T(pixel[1])) / T(sigma);
    return true;
  }
};

/// Angle between an outline's ray and the sphere's cone, in pixels.
struct OutlineError {
  Vec3 eye;
  Vec3 ray;  ///< Unit.
  double radius;
  double px_per_radian;
  double sigma;

  template <class T>
  bool operator()(const T* center_numbers, T* error) const {
    const Vec3T<T> to_center = Eigen::Map<const Vec3T<T>>(center_numbers) - eye.cast<T>();
    const T distance = to_center.norm();
    if (!(distance > T(radius))) return false;
    // Sine of the difference: both angles can be tiny, with a camera far away.
    const T across = to_center.cross(ray.cast<T>()).norm() / distance, along = to_center.dot(ray.cast<T>()) / distance;
    const T sine = T(radius) / distance, cosine = sqrt(T(1.0) - sine * sine);
    error[0] = T(px_per_radian / sigma) * (across * cosine - along * sine);
    return true;
  }
};

double outline_scale(const Camera& camera, const Vec3& ray, const Vec3& center) {
  const Vec3 axis = (center - camera.center()).normalized();
  const double angle = std::atan2(axis.cross(ray).norm(), axis.dot(ray));
  const Vec3 turn = axis.cross(ray).normalized();
  const auto at = [&](double by) { return camera.project(camera.center() + Eigen::AngleAxisd(by, turn) * ray); };
  const double step = 0.01 * angle;
  const auto inner = at(-step), outer = at(step);
  return inner && outer ? (*outer - *inner).norm() / (2.0 * step) : 0.0;
}

constexpr double kHuberSigmas = 3.0;  ///< Standard deviations (docs/algorithms/light_calibration.md).

}  // namespace

SphereLightSolution refine_sphere_lights(const Camera& camera, const std::vector<MirrorSphere>& spheres,
                                         const Highlights& highlights, const SphereLightOptions& options,
                                         SphereLightProblem& start) {
  const FixedCamera fixed(camera);
  ceres::Problem problem;
  for (std::size_t s = 0; s < spheres.size(); ++s) {
    problem.AddParameterBlock(start.centers[s].data(), 3);
    for (const Vec2& p : spheres[s].outline_px) {
      const auto ray = camera.ray(p);
      if (!ray) continue;
      const double scale = outline_scale(camera, ray->direction, start.centers[s]);
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<OutlineError, 1, 3>(
              new OutlineError{camera.center(), ray->direction, spheres[s].radius_mm, scale, options.outline_sigma_px}),
          nullptr, start.centers[s].data());
    }
  }
  std::vector<std::vector<ceres::ResidualBlockId>> blocks(start.lights.size());
  for (std::size_t k = 0; k < start.lights.size(); ++k) {
    if (!start.is_used[k]) continue;
    problem.AddParameterBlock(start.lights[k].data(), 3);
    if (!start.is_near[k]) problem.SetManifold(start.lights[k].data(), new ceres::SphereManifold<3>());
    for (std::size_t s = 0; s < spheres.size(); ++s) {
      if (!highlights[k][s]) continue;
      const auto mirrored = mirrored_ray(camera, start.centers[s], spheres[s].radius_mm, *highlights[k][s]);
      if (!mirrored) continue;
      auto* error = new HighlightError{&fixed,
                                       *highlights[k][s],
                                       spheres[s].radius_mm,
                                       options.highlight_sigma_px,
                                       start.is_near[k],
                                       (mirrored->point - start.centers[s]).normalized()};
      blocks[k].push_back(problem.AddResidualBlock(new ceres::AutoDiffCostFunction<HighlightError, 2, 3, 3>(error),
                                                   new ceres::HuberLoss(kHuberSigmas), start.centers[s].data(),
                                                   start.lights[k].data()));
    }
  }
  SphereLightSolution solution;
  solution.has_converged = solve_quietly(problem).has_converged;
  std::vector<double*> parameters;
  std::vector<int> first(start.lights.size(), -1);
  int num_parameters = 0;
  for (std::size_t k = 0; k < start.lights.size(); ++k) {
    if (!start.is_used[k]) continue;
    parameters.push_back(start.lights[k].data());
    first[k] = num_parameters;
    num_parameters += start.is_near[k] ? 3 : 2;
  }
  for (Vec3& center : start.centers) parameters.push_back(center.data());
  const Information info = information_of(problem, parameters);
  solution.is_determined = info.is_determined;
  const int num_left = info.num_residuals - info.num_parameters;
  const double scale = num_left >= 10 ? std::max(1.0, info.sum_squares / num_left) : 1.0;
  solution.covariances.assign(start.lights.size(), Eigen::Matrix3d::Zero());
  solution.rms_px.assign(start.lights.size(), 0.0);
  for (std::size_t k = 0; k < start.lights.size(); ++k) {
    if (!start.is_used[k]) continue;
    if (info.is_determined && start.is_near[k]) {
      solution.covariances[k] = scale * info.covariance.block<3, 3>(first[k], first[k]);
    } else if (info.is_determined) {
      Eigen::Matrix<double, 3, 2, Eigen::RowMajor> plus;
      ceres::SphereManifold<3>().PlusJacobian(start.lights[k].data(), plus.data());
      solution.covariances[k] = scale * plus * info.covariance.block<2, 2>(first[k], first[k]) * plus.transpose();
    }
    double squares = 0.0;
    for (const ceres::ResidualBlockId block : blocks[k]) {
      double cost = 0.0;
      problem.EvaluateResidualBlock(block, false, &cost, nullptr, nullptr);
      squares += 2.0 * cost;
    }
    if (!blocks[k].empty())
      solution.rms_px[k] = options.highlight_sigma_px * std::sqrt(squares / static_cast<double>(blocks[k].size()));
  }
  return solution;
}

}  // namespace patinate::capture
