#include "patinate/capture/camera_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/support/errors.h"

namespace patinate::capture {
namespace {

using testing_support::error_of;
using testing_support::has;

CameraParameters true_camera(bool has_lens = true) {
  CameraParameters p;
  p.width = 1600, p.height = 1200;
  p.fx = 1805, p.fy = 1798, p.cx = 812.5, p.cy = 590.25;
  if (has_lens) p.distortion = {-0.18, 0.06, 6e-4, -4e-4, 0.0};
  p.rotation = Eigen::AngleAxisd(2.6, Vec3(1, 0.2, -0.1).normalized()).toRotationMatrix();
  p.translation = {15, -20, 420};
  return p;
}

/// A target of 9 x 7 points, 15 mm apart.
std::vector<Vec3> target_points() {
  std::vector<Vec3> points;
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 9; ++x) points.emplace_back(15.0 * x, 15.0 * y, 0.0);
  }
  return points;
}

struct Views {
  std::vector<PointView> targets;
  PointView scanner;
};

/// Views from `num` sides, tilted up to `tilt` radians, and 40 scanner points in a box of 160 x 120 x 60 mm.
Views views_of(const CameraParameters& truth, int num, double tilt, double sigma, std::uint64_t seed) {
  Views views;
  RandomStream random(seed, 0, 0);
  const auto noisy = [&](const CameraParameters& p, const Vec3& point) {
    return Vec2(*Camera(p).project(point) + sigma * Vec2(random.normal(), random.normal()));
  };
  for (int v = 0; v < num; ++v) {
    CameraParameters p = truth;
    const double side = 2.4 * v;
    p.rotation = Eigen::AngleAxisd(tilt, Vec3(std::cos(side), std::sin(side), 0)).toRotationMatrix() *
                 Eigen::AngleAxisd(0.3 * v, Vec3::UnitZ()).toRotationMatrix();
    p.translation = Vec3(10.0 * (v % 3 - 1), 8.0 * (v % 4 - 1.5), 330 + 15 * (v % 5)) - p.rotation * Vec3(60, 45, 0);
    PointView view{.points_mm = target_points(), .pixels = {}, .name = ""};
    for (const Vec3& point : view.points_mm) view.pixels.push_back(noisy(p, point));
    views.targets.push_back(view);
  }
  for (int i = 0; i < 40; ++i) {
    views.scanner.points_mm.emplace_back(160 * random.uniform() - 80, 120 * random.uniform() - 60,
                                         60 * random.uniform());
    views.scanner.pixels.push_back(noisy(truth, views.scanner.points_mm.back()));
  }
  return views;
}

/// Estimate less truth in the order of the covariance.
Eigen::VectorXd deviation_of(const CameraCalibration& c, const CameraParameters& truth) {
  Eigen::VectorXd e(kNumCameraNumbers);
  const CameraParameters& p = c.camera;
  e.head<4>() << p.fx - truth.fx, p.fy - truth.fy, p.cx - truth.cx, p.cy - truth.cy;
  for (int i = 0; i < 5; ++i) e[4 + i] = p.distortion[i] - truth.distortion[i];
  e.segment<3>(9) = axis_angle_of(p.rotation * truth.rotation.transpose());
  e.tail<3>() = p.translation - truth.translation;
  return e;
}

TEST(CameraCalibration, ExactPixelsGiveTheCameraToRounding) {
  const CameraParameters truth = true_camera();
  const Views views = views_of(truth, 6, 0.5, 0.0, 1);
  const CameraCalibration c = calibrate_camera(1600, 1200, views.targets, views.scanner);
  EXPECT_EQ(c.status, CalibrationStatus::Converged);
  const Eigen::VectorXd e = deviation_of(c, truth);
  constexpr double kRoundingPx = 1e-6;
  EXPECT_LT(e.head<4>().norm(), kRoundingPx);
  EXPECT_LT(e.segment<8>(4).norm(), 1e-8);
  EXPECT_LT(e.tail<3>().norm(), kRoundingPx);
  EXPECT_LT(c.rms_px, kRoundingPx);
  ASSERT_EQ(c.views.size(), 7u);
  EXPECT_EQ(c.views[6].name, "scanner points");
}

TEST(CameraCalibration, NoiseMovesEveryNumberByWhatTheCovarianceSays) {
  const CameraParameters truth = true_camera();
  constexpr int kTrials = 12;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(kNumCameraNumbers);
  for (int trial = 0; trial < kTrials; ++trial) {
    const Views views = views_of(truth, 6, 0.5, 0.2, 100 + static_cast<std::uint64_t>(trial));
    const CameraCalibration c = calibrate_camera(1600, 1200, views.targets, views.scanner);
    ASSERT_EQ(c.status, CalibrationStatus::Converged);
    EXPECT_NEAR(c.sigma_px, 0.2, 0.02);
    const Eigen::VectorXd e = deviation_of(c, truth);
    for (int i = 0; i < kNumCameraNumbers; ++i) {
      const double sd = std::sqrt(c.covariance(i, i));
      if (i == 8) {
        EXPECT_EQ(sd, 0.0);  // k3 is not fitted.
        continue;
      }
      EXPECT_LT(std::abs(e[i]), 4.5 * sd) << camera_number_name(i);
      squares[i] += e[i] * e[i] / (sd * sd) / kTrials;
    }
  }
  // Chi-square of 12: mean 1, 4 sd of it.
  for (int i = 0; i < kNumCameraNumbers; ++i) {
    if (i == 8) continue;
    EXPECT_NEAR(squares[i], 1.0, 4.0 * std::sqrt(2.0 / kTrials)) << camera_number_name(i);
  }
}

TEST(CameraCalibration, WrongPointsCountLittleAndAreCounted) {
  const CameraParameters truth = true_camera();
  Views views = views_of(truth, 6, 0.5, 0.2, 3);
  views.targets[2].pixels[10] += Vec2(40, -25);
  views.scanner.pixels[5] += Vec2(-30, 30);
  const CameraCalibration c = calibrate_camera(1600, 1200, views.targets, views.scanner);
  EXPECT_EQ(c.status, CalibrationStatus::Converged);
  EXPECT_GE(c.views[2].num_outliers, 1);
  EXPECT_GE(c.views[6].num_outliers, 1);
  const Eigen::VectorXd e = deviation_of(c, truth);
  for (int i = 0; i < kNumCameraNumbers; ++i) {
    if (i == 8) continue;
    EXPECT_LT(std::abs(e[i]), 6 * std::sqrt(c.covariance(i, i))) << camera_number_name(i);
  }
}

TEST(CameraCalibration, ScannerPointsAloneDoWhenTheyFillABox) {
  const CameraParameters truth = true_camera(false);
  const Views views = views_of(truth, 0, 0.0, 0.0, 4);
  const CameraCalibration c = calibrate_camera(1600, 1200, {}, views.scanner, {.lens = LensTerms::None});
  EXPECT_EQ(c.status, CalibrationStatus::Converged);
  EXPECT_LT(deviation_of(c, truth).head<4>().norm(), 1e-5);
}

TEST(CameraCalibration, FrontalViewsLeaveTheFocalLengthOpenAndSaySo) {
  const CameraParameters truth = true_camera(false);
  Views views = views_of(truth, 5, 0.0, 0.0, 5);
  const CameraCalibration c = calibrate_camera(1600, 1200, views.targets, {}, {.lens = LensTerms::None});
  EXPECT_EQ(c.status, CalibrationStatus::Undetermined);
  EXPECT_FALSE(c.weakest.empty());
  views = views_of(truth, 5, 0.01, 0.2, 5);
  EXPECT_EQ(calibrate_camera(1600, 1200, views.targets, {}).status, CalibrationStatus::Undetermined);
}

TEST(CameraCalibration, MistakesAreNamed) {
  const CameraParameters truth = true_camera(false);
  const Views good = views_of(truth, 3, 0.5, 0.0, 6);
  const auto error = [&](const auto& change) {
    Views views = good;
    change(views);
    return error_of([&] { (void)calibrate_camera(1600, 1200, views.targets, views.scanner); });
  };
  EXPECT_EQ(error([](Views&) {}), "");
  EXPECT_TRUE(has(error([](Views& v) { v.targets[1].pixels.pop_back(); }), "view 2: 63 points, but 62 pixels"));
  EXPECT_TRUE(
      has(error([](Views& v) { v.targets[1].pixels.resize(3), v.targets[1].points_mm.resize(3); }), "at least 4"));
  EXPECT_TRUE(has(error([](Views& v) { v.targets[1].pixels.resize(9), v.targets[1].points_mm.resize(9); }),
                  "view 2: its points lie on a line"));
  EXPECT_TRUE(has(error([](Views& v) { v.targets[0].pixels[7].x() = std::nan(""); }), "point 8 is not finite"));
  EXPECT_TRUE(has(error([](Views& v) { v.targets.clear(), v.scanner = {}; }), "views of a target or scanner points"));
  EXPECT_TRUE(has(error([](Views& v) {
                    v.targets.clear();
                    for (Vec3& p : v.scanner.points_mm) p.z() = 0;
                  }),
                  "lie on a plane"));
  EXPECT_TRUE(has(error([](Views& v) {
                    v.targets.resize(1), v.targets[0].pixels.resize(5),
                        v.targets[0].points_mm = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {9, 9, 0}, {5, 5, 0}};
                    v.scanner = {};
                  }),
                  "too few points: 10 numbers for 14 unknowns"));
}

}  // namespace
}  // namespace patinate::capture
