#include "patinate/capture/camera_calibration.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "capture/calibration/brown_projection.h"
#include "capture/calibration/ceres_solve.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

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

constexpr double kMinSigmaPx = 1e-7;  ///< Exact pixels have no scale of their own.
/// Rounds with the noise estimated from residuals (docs/algorithms/camera_calibration.md).
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

/// How many of k1 k2 p1 p2 k3 are fitted.
int num_lens_terms(LensTerms lens) {
  // Distortion terms of each lens model, in the order of kLensNames.
  constexpr std::array<int, 5> kNumTerms{0, 1, 2, 4, 5};
  return kNumTerms[static_cast<std::size_t>(lens)];
}

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

/// Refines `problem` in place.
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
    const double typical = std::max(kMinSigmaPx, robust_sigma(residuals));
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

constexpr std::array<std::string_view, 5> kLensNames{"none", "k1", "k1k2", "k1k2p1p2", "all"};
constexpr std::array<const char*, kNumCameraNumbers> kNames{"fx", "fy",     "cx",     "cy",     "k1", "k2", "p1", "p2",
                                                            "k3", "turn_x", "turn_y", "turn_z", "x",  "y",  "z"};

/// Sizes of a set of points: standard deviations along its axes, ascending.
Vec3 extents_of(const std::vector<Vec3>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) moments += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  return symmetric_eigen(moments).values.cwiseMax(0.0).cwiseSqrt();
}

std::string view_name(const PointView& view, std::size_t index) {
  return view.name.empty() ? "view " + std::to_string(index + 1) : view.name;
}

void check_view(const PointView& view, const std::string& name, std::size_t at_least) {
  if (view.points_mm.size() != view.pixels.size()) {
    throw InvalidInput(name + ": " + std::to_string(view.points_mm.size()) + " points, but " +
                       std::to_string(view.pixels.size()) + " pixels");
  }
  if (view.pixels.size() < at_least)
    throw InvalidInput(name + ": " + std::to_string(view.pixels.size()) + " points; at least " +
                       std::to_string(at_least) + " are needed");
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    if (!view.points_mm[i].allFinite() || !view.pixels[i].allFinite())
      throw InvalidInput(name + ": point " + std::to_string(i + 1) + " is not finite");
  }
  const Vec3 extents = extents_of(view.points_mm);
  constexpr double kLine = 1e-6;  // Ratio of extents, below which points lie on a line.
  if (!(extents[1] > kLine * extents[2])) throw InvalidInput(name + ": its points lie on a line");
}

/// The pose that fits a view best for a camera without distortion, and the squares of the residuals in pixels; nothing
/// where there is none.
struct Start {
  RigidTransform pose;
  double squares = 0.0;
};
std::optional<Start> start_of_view(const PointView& view, double focal, double cx, double cy) {
  const cv::Matx33d k(focal, 0, cx, 0, focal, cy, 0, 0, 1);
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    points.emplace_back(view.points_mm[i].x(), view.points_mm[i].y(), view.points_mm[i].z());
    pixels.emplace_back(view.pixels[i].x(), view.pixels[i].y());
  }
  cv::Mat turn, shift, rotation;
  try {
    if (!cv::solvePnP(points, pixels, k, cv::noArray(), turn, shift, false, cv::SOLVEPNP_SQPNP)) return std::nullopt;
    cv::Rodrigues(turn, rotation);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  Start start;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) start.pose.rotation(r, c) = rotation.at<double>(r, c);
    start.pose.translation[r] = shift.at<double>(r);
  }
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const Vec3 p = start.pose.apply(view.points_mm[i]);
    if (!(p.z() > 0)) return std::nullopt;
    start.squares += (Vec2(focal * p.x() / p.z() + cx, focal * p.y() / p.z() + cy) - view.pixels[i]).squaredNorm();
  }
  return start.pose.rotation.allFinite() && std::isfinite(start.squares) ? std::optional(start) : std::nullopt;
}

/// The best of a series of focal lengths. @throws InvalidInput when a view fits none.
CameraProblem start_of_camera(int width, int height, const std::vector<const PointView*>& views) {
  CameraProblem best;
  double least = std::numeric_limits<double>::infinity();
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  // Focal lengths that are tried, 0.3 to 20 sides (docs/algorithms/camera_calibration.md).
  constexpr int kNumFocals = 18;
  for (int i = 0; i < kNumFocals; ++i) {
    const double focal = std::max(width, height) * 0.3 * std::pow(20.0 / 0.3, i / (kNumFocals - 1.0));
    CameraProblem problem;
    problem.focal_center = {focal, focal, cx, cy};
    double squares = 0.0;
    for (const PointView* view : views) {
      const std::optional<Start> start = start_of_view(*view, focal, cx, cy);
      if (!start) {
        squares = std::numeric_limits<double>::infinity();
        break;
      }
      problem.poses.push_back(start->pose);
      squares += start->squares;
    }
    if (squares < least) least = squares, best = problem;
  }
  if (best.poses.empty())
    throw InvalidInput("no pose of the target fits the pixels; check that points and pixels are in the same order");
  return best;
}

/// A stacked parameter of the information as one of the camera's numbers; -1 for the pose of another view.
int number_of(int parameter, int num_lens, bool has_pose) {
  if (parameter < 4 + num_lens) return parameter;
  const int pose = parameter - 4 - num_lens;
  return has_pose && pose < 6 ? 9 + pose : -1;
}

}  // namespace

void describe(OptionVisitor& v, CameraCalibrationOptions& o) {
  v.visit_choice({"lens", "terms of the lens that are fitted"}, o.lens, kLensNames);
  v.visit({"huber_sigmas", "points farther off than so many standard deviations weigh less", "", above(0)},
          o.huber_sigmas);
  v.visit({"max_focal_sd", "a focal length known worse than this share of it counts as not determined", "", above(0)},
          o.max_focal_sd);
}

std::string calibration_status_text(CalibrationStatus status) {
  switch (status) {
    case CalibrationStatus::Converged:
      return "converged";
    case CalibrationStatus::Undetermined:
      return "undetermined";
    case CalibrationStatus::IterationLimit:
      return "iteration limit";
  }
  return "";
}

const char* camera_number_name(int index) { return kNames[index]; }

CameraCalibration calibrate_camera(int width, int height, const std::vector<PointView>& targets,
                                   const PointView& scanner, const CameraCalibrationOptions& options,
                                   const RunControl& control) {
  check_ranges(options);
  if (width < 1 || height < 1 || width > 65536 || height > 65536)
    throw InvalidInput("the photographs' size is out of range; expected 1 to 65536 pixels");
  std::vector<const PointView*> views;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    names.push_back(view_name(targets[i], i));
    check_view(targets[i], names.back(), 4);
    views.push_back(&targets[i]);
  }
  const bool has_scanner = !scanner.points_mm.empty() || !scanner.pixels.empty();
  if (has_scanner) {
    names.push_back("scanner points");
    check_view(scanner, names.back(), targets.empty() ? 6 : 3);
    views.push_back(&scanner);
    const Vec3 extents = extents_of(scanner.points_mm);
    constexpr double kFlat = 1e-4;  // Ratio of extents, below which points lie in a plane.
    if (targets.empty() && !(extents[0] > kFlat * extents[2])) {
      throw InvalidInput("the scanner points lie on a plane; without views of a target they must not");
    }
  }
  if (views.empty()) throw InvalidInput("a camera needs views of a target or scanner points");
  std::size_t num_numbers = 0;
  for (const PointView* view : views) num_numbers += 2 * view->pixels.size();
  const std::size_t num_unknowns = 4 + static_cast<std::size_t>(num_lens_terms(options.lens)) + 6 * views.size();
  if (num_numbers < num_unknowns) {
    throw InvalidInput("too few points: " + std::to_string(num_numbers) + " numbers for " +
                       std::to_string(num_unknowns) + " unknowns");
  }

  CameraProblem problem = start_of_camera(width, height, views);
  control.throw_if_stopped();
  const CameraSolution solution = refine_camera(views, options, problem);

  CameraCalibration result;
  result.has_scanner_pose = has_scanner;
  result.sigma_px = solution.sigma_px;
  const std::size_t own = has_scanner ? views.size() - 1 : 0;
  CameraParameters& p = result.camera;
  p.width = width, p.height = height;
  p.fx = problem.focal_center[0], p.fy = problem.focal_center[1], p.cx = problem.focal_center[2],
  p.cy = problem.focal_center[3];
  p.distortion = problem.lens;
  p.rotation = problem.poses[own].rotation;
  p.translation = problem.poses[own].translation;

  double squares = 0.0;
  std::size_t num_points = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    CameraCalibration::View view{.name = names[v],
                                 .camera_from_target = problem.poses[v],
                                 .num_points = static_cast<int>(views[v]->pixels.size())};
    double sum = 0.0;
    for (const double r : solution.residuals[v]) {
      sum += r * r;
      view.max_px = std::max(view.max_px, r);
      if (r > std::sqrt(2.0) * options.huber_sigmas * std::max(solution.sigma_px, 1e-6)) ++view.num_outliers;
    }
    view.rms_px = std::sqrt(sum / view.num_points);
    squares += sum, num_points += solution.residuals[v].size();
    result.views.push_back(std::move(view));
  }
  result.rms_px = std::sqrt(squares / static_cast<double>(num_points));

  // The last view stands first among the poses: the scanner's where there is one.
  const Information& info = solution.information;
  const int num_lens = num_lens_terms(options.lens);
  result.covariance.setZero();
  const auto size = static_cast<int>(info.weakest.size());
  double worst = 0.0;
  for (int i = 0; i < size; ++i) {
    const int a = number_of(i, num_lens, has_scanner);
    if (std::abs(info.weakest[i]) > worst)
      worst = std::abs(info.weakest[i]), result.weakest = a >= 0 ? camera_number_name(a) : "a view's pose";
    for (int k = 0; k < size && info.is_determined; ++k) {
      const int b = number_of(k, num_lens, has_scanner);
      if (a >= 0 && b >= 0) result.covariance(a, b) = solution.sigma_px * solution.sigma_px * info.covariance(i, k);
    }
  }
  const double focal_sd =
      std::sqrt(std::max(result.covariance(0, 0) / (p.fx * p.fx), result.covariance(1, 1) / (p.fy * p.fy)));
  const bool is_camera = p.fx > 0 && p.fy > 0 && std::isfinite(p.fx) && std::isfinite(p.fy);
  if (!info.is_determined || !is_camera || focal_sd > options.max_focal_sd) {
    result.status = CalibrationStatus::Undetermined;
  } else {
    result.status = solution.has_converged ? CalibrationStatus::Converged : CalibrationStatus::IterationLimit;
  }
  return result;
}

}  // namespace patinate::capture
