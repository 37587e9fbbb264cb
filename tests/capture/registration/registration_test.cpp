#include "patinate/capture/registration.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "capture/registration/rotation_search.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/capture/registration/scan_shapes.h"

namespace patinate::capture {
namespace {

using testing_support::GridScan;
using testing_support::largest_gap;
using testing_support::mirrored;
using testing_support::part_of;
using testing_support::relief;
using testing_support::scan_of;

constexpr double kPi = 3.14159265358979323846;

/// A turn about the scan's middle and a shift.
RigidTransform motion(const Vec3& axis, double angle_deg, const Vec3& shift) {
  return {rotation_of(axis.normalized() * (angle_deg * kPi / 180.0)), shift};
}

TEST(RegisterPair, RecoversAKnownMotionToRounding) {
  const PointCloud target = scan_of(relief);
  const RigidTransform source_from_target = motion(Vec3(1, 2, 3), 12.0, Vec3(5, -3, 8));
  const PairRegistration found = register_pair(target, moved(target, source_from_target), RigidTransform{});
  EXPECT_EQ(found.status, RegistrationStatus::Converged);
  EXPECT_FALSE(found.is_found_by_search);
  // Rounding of coordinates of 100 mm through two transforms and 3 x 3 eigenvectors.
  EXPECT_LT(largest_gap(target, found.target_from_source * source_from_target, {}), 1e-10);
  EXPECT_LT(found.rms_residual, 1e-10);
  EXPECT_NEAR(found.overlap, 1.0, 1e-12);
}

TEST(RegisterPair, StaysWithinItsCovarianceUnderNoise) {
  // Other points of the same surface, each with noise of its own: the error, in units of the covariance, is a
  // chi-square of 6 degrees of freedom. Its mean over n runs lies within 4 sd of 6; one run passes 33 once in 10^5. The
  // covariance may be too large by the scatter that curvature adds to it, by a factor of 2 at most here.
  const GridScan grid{.noise_mm = 0.1};
  constexpr int kRuns = 12;
  double sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const auto seed = static_cast<std::uint64_t>(2 * run + 10);
    const PointCloud target = scan_of(relief, {.noise_mm = grid.noise_mm, .seed = seed});
    const RigidTransform source_from_target = motion(Vec3(1, -run, 2), 4.0, Vec3(2, 1, -1));
    const PointCloud source =
        moved(scan_of(relief, {.offset = 0.37, .noise_mm = grid.noise_mm, .seed = seed + 1}), source_from_target);
    const PairRegistration found = register_pair(target, source, RigidTransform{});
    ASSERT_EQ(found.status, RegistrationStatus::Converged);
    const RigidTransform error = found.target_from_source * source_from_target;
    Vec6 e;
    e << axis_angle_of(error.rotation), error.apply(found.center) - found.center;
    const double chi_square = e.dot(found.covariance.llt().solve(e));
    EXPECT_LT(chi_square, 33.0);
    sum += chi_square;
  }
  const double sd = std::sqrt(2.0 * 6.0 / kRuns);
  EXPECT_LT(sum / kRuns, 6.0 + 4.0 * sd);
  EXPECT_GT(sum / kRuns, 6.0 / 2.0 - 4.0 * sd / 2.0);
}

TEST(RegisterPair, SwappedScansGiveTheInverse) {
  const PointCloud target = scan_of(relief, {.noise_mm = 0.05, .seed = 1});
  const RigidTransform start = motion(Vec3(0, 1, 1), 8.0, Vec3(3, 0, 1));
  const PointCloud source = moved(part_of(scan_of(relief, {.offset = 0.41, .noise_mm = 0.05, .seed = 2}),
                                          [](const Vec3& p) { return p.x() < 25.0; }),
                                  start.inverse());
  const RigidTransform guess = motion(Vec3(1, 0, 0), 3.0, Vec3(0, 1, 0)) * start;
  const PairRegistration forth = register_pair(target, source, guess),
                         back = register_pair(source, target, guess.inverse());
  EXPECT_EQ(forth.status, RegistrationStatus::Converged);
  EXPECT_EQ(back.status, RegistrationStatus::Converged);
  // Both end where nothing moves by more than 1e-10 of the object's size.
  EXPECT_LT(largest_gap(source, back.target_from_source * forth.target_from_source, {}), 1e-6);
  EXPECT_NEAR(forth.overlap, back.overlap, 1e-12);
}

TEST(RegisterPair, NeitherUnitNorOriginMatter) {
  const PointCloud target = scan_of(relief, {.size = 80, .noise_mm = 0.05, .seed = 3});
  const PointCloud source = moved(scan_of(relief, {.size = 80, .offset = 0.3, .noise_mm = 0.05, .seed = 4}),
                                  motion(Vec3(1, 1, 0), 5.0, Vec3(1, 2, 3)));
  const PairRegistration plain = register_pair(target, source, RigidTransform{});
  ASSERT_EQ(plain.status, RegistrationStatus::Converged);
  for (const double unit : {1e-3, 25.4}) {
    PointCloud a = target, b = source;
    scale_cloud(a, unit);
    scale_cloud(b, unit);
    PairRegistration found = register_pair(a, b, RigidTransform{});
    found.target_from_source.translation /= unit;
    EXPECT_LT(largest_gap(source, found.target_from_source, plain.target_from_source), 1e-9 * 100.0) << unit;
    EXPECT_NEAR(found.rms_residual / unit, plain.rms_residual, 1e-9 * plain.rms_residual + 1e-12);
  }
  const RigidTransform far{Eigen::Matrix3d::Identity(), Vec3(1e6, -1e6, 5e5)};
  const PairRegistration found = register_pair(moved(target, far), moved(source, far), RigidTransform{});
  // Coordinates of 10^6 are rounded to 10^-10 before registration sees them.
  EXPECT_LT(largest_gap(source, far.inverse() * found.target_from_source * far, plain.target_from_source), 1e-8);
}

TEST(RegisterPair, GivesTheSameBitsForAnyNumberOfThreads) {
  const PointCloud target = scan_of(relief, {.size = 90, .noise_mm = 0.05, .seed = 5});
  const PointCloud source = moved(scan_of(relief, {.size = 90, .offset = 0.3, .noise_mm = 0.05, .seed = 6}),
                                  motion(Vec3(1, 1, 1), 70.0, Vec3(1, 2, 3)));
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  const PairRegistration a = register_pair(target, source, std::nullopt, {}, one),
                         b = register_pair(target, source, std::nullopt, {}, three);
  EXPECT_EQ(a.status, RegistrationStatus::Converged);
  EXPECT_TRUE(a.is_found_by_search);
  EXPECT_EQ(a.target_from_source.rotation, b.target_from_source.rotation);
  EXPECT_EQ(a.target_from_source.translation, b.target_from_source.translation);
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(RegisterPair, NamesWhatAPlaneACylinderAndASphereLeaveOpen) {
  struct Case {
    const char* name;
    std::function<double(double, double)> height;
    std::vector<UnconstrainedDof::Kind> motions;
  };
  using enum UnconstrainedDof::Kind;
  const std::vector<Case> cases{
      {"plane", [](double x, double y) { return 0.1 * x - 0.2 * y; }, {Shift, Shift, Turn}},
      {"cylinder", [](double, double y) { return std::sqrt(60.0 * 60.0 - y * y) - 40.0; }, {Shift, Turn}},
      {"sphere", [](double x, double y) { return std::sqrt(75.0 * 75.0 - x * x - y * y) - 50.0; }, {Turn, Turn, Turn}},
  };
  for (const Case& c : cases) {
    for (const double noise : {0.0, 0.05}) {
      const PointCloud target = scan_of(c.height, {.noise_mm = noise, .seed = 7}),
                       source = scan_of(c.height, {.offset = 0.43, .noise_mm = noise, .seed = 8});
      const PairRegistration found = register_pair(target, source, motion(Vec3(0, 1, 0.3), 0.3, Vec3(0.2, 0, 0.5)),
                                                   {.start = RegistrationStart::Given});
      EXPECT_EQ(found.status, RegistrationStatus::Degenerate)
          << c.name << ", noise " << noise << ": " << name_of(found.status);
      std::vector<UnconstrainedDof::Kind> kinds;
      for (const UnconstrainedDof& m : found.unconstrained_dofs) kinds.push_back(m.kind);
      EXPECT_EQ(kinds, c.motions) << c.name << ", noise " << noise;
      if (c.motions.size() == 2 && kinds == c.motions) {
        EXPECT_GT(std::abs(found.unconstrained_dofs[1].direction.x()), 0.999) << "the axis of the cylinder is x";
      }
      // Determined motions are found all the same: every point of the moved scan lies on the surface again.
      double off = 0.0;
      for (std::size_t i = 0; i < source.points.size(); i += 97) {
        const Vec3 p = found.target_from_source.apply(source.points[i]);
        off = std::max(off, std::abs(p.z() - c.height(p.x(), p.y())));
      }
      EXPECT_LT(off, 6.0 * noise + 0.02) << c.name;
    }
  }
}

TEST(RegisterPair, FindsAnObjectTurnedByAnyAngle) {
  const PointCloud target = scan_of(relief, {.noise_mm = 0.05, .seed = 20});
  for (int k = 0; k < 3; ++k) {
    RandomStream random(9, static_cast<std::uint64_t>(k));
    const Vec3 axis(random.normal(), random.normal(), random.normal());
    const RigidTransform source_from_target = motion(axis, 60.0 + 60.0 * k, Vec3(300.0 * random.normal(), 0, 200));
    const PointCloud part = part_of(scan_of(relief, {.offset = 0.3, .noise_mm = 0.05, .seed = 21}),
                                    [](const Vec3& p) { return p.y() > -20.0; });
    const PairRegistration found = register_pair(target, moved(part, source_from_target), std::nullopt);
    EXPECT_EQ(found.status, RegistrationStatus::Converged);
    // Noise of 0.05 mm over 10^4 points leaves micrometers.
    EXPECT_LT(largest_gap(part, found.target_from_source * source_from_target, {}), 0.02) << k;
    EXPECT_EQ(found.ambiguous_deg, 0.0) << k;
  }
}

TEST(RegisterPair, SaysByWhatTurnASymmetricObjectFitsAsWell) {
  const auto fourfold = [](double x, double y) { return 4.0 * std::cos(x / 9.0) * std::cos(y / 9.0); };
  const PointCloud target = scan_of(fourfold, {.noise_mm = 0.05, .seed = 24}),
                   source = scan_of(fourfold, {.offset = 0.3, .noise_mm = 0.05, .seed = 25});
  const PairRegistration found = register_pair(target, source, std::nullopt);
  EXPECT_EQ(found.status, RegistrationStatus::Converged);
  // A quarter or half a turn, or over onto its other side. Poses are told apart from two degrees on.
  EXPECT_NEAR(std::remainder(found.ambiguous_deg, 90.0), 0.0, 2.0);
  EXPECT_GE(found.ambiguous_deg, 88.0);
  // Whoever knows about where it stands is not asked.
  EXPECT_EQ(register_pair(target, source, RigidTransform{}).ambiguous_deg, 0.0);
}

TEST(RegisterPair, AMirroredScanIsNoFit) {
  const PointCloud target = scan_of(relief, {.noise_mm = 0.05, .seed = 22});
  const PairRegistration found =
      register_pair(target, mirrored(scan_of(relief, {.offset = 0.3, .noise_mm = 0.05, .seed = 23})), std::nullopt);
  EXPECT_NE(found.status, RegistrationStatus::Converged);
  EXPECT_NE(found.status, RegistrationStatus::Degenerate);
}

TEST(RegisterPair, ScansThatShareNothingAreNoFit) {
  const PointCloud whole = scan_of(relief, {.size = 110});
  const PointCloud left = part_of(whole, [](const Vec3&p) { return p.x() < -5.0; }),
                   right = part_of(whole, [](const Vec3&p) { return p.x() > 5.0; });
  for (const auto& start : {std::optional<RigidTransform>(RigidTransform{}), std::optional<RigidTransform>()}) {
    const PairRegistration found = register_pair(left, right, start);
    EXPECT_NE(found.status, RegistrationStatus::Converged);
    EXPECT_NE(found.status, RegistrationStatus::Degenerate);
  }
}

TEST(RegisterPair, APartThatChangedDoesNotPullTheRest) {
  // A fifth of the surface has grown by 1.5 mm; plain least squares over all of it would be off by a good part of that.
  const auto grown = [](double x, double y) { return relief(x, y) + (x > 30.0 ? 1.5 : 0.0); };
  const PointCloud target = scan_of(relief, {.noise_mm = 0.03, .seed = 30}),
                   source = scan_of(grown, {.offset = 0.4, .noise_mm = 0.03, .seed = 31});
  const PairRegistration found = register_pair(target, source, motion(Vec3(1, 0, 1), 2.0, Vec3(1, 1, 1)));
  EXPECT_EQ(found.status, RegistrationStatus::Converged);
  EXPECT_LT(largest_gap(source, found.target_from_source, {}), 0.03);
  EXPECT_LT(found.overlap, 0.95) << "and what changed is not counted as partners, but for what lies within the gate";
}

TEST(RegisterPair, StatesWhatItWouldMoveByWereTheChangedShareMisjudged) {
  // Growth that begins gently, on half or on all of the surface but one edge: what fits most of it takes a part of the
  // growth along. What grows everywhere alike is not to be seen at all.
  const auto error_over_stated = [](double share, PairRegistration& found) {
    const auto grown = [share](double x, double y) {
      const double u = std::clamp((x + 50.0) / 100.0 - (1.0 - share), 0.0, 1.0);
      return relief(x, y) + 2.0 * u * (1.0 + 0.5 * std::sin(0.3 * y));
    };
    const PointCloud target = scan_of(relief, {.noise_mm = 0.02, .seed = 50}),
                     source = scan_of(grown, {.offset = 0.4, .noise_mm = 0.02, .seed = 51});
    found = register_pair(target, source, RigidTransform{});
    const Vec3 off = found.target_from_source.apply(found.center) - found.center;
    return off.norm() /
           std::sqrt(found.covariance.bottomRightCorner<3, 3>().trace() + found.misjudged.tail<3>().squaredNorm());
  };
  PairRegistration some, all;
  // Right order only: the part that is taken for unchanged is not the unchanged one to a point.
  EXPECT_LT(error_over_stated(0.5, some), 3.0);
  EXPECT_LT(error_over_stated(1.0, all), 3.0);
  EXPECT_GT(some.staying, 0.4);
  EXPECT_LT(all.staying, 0.4);
  PairRegistration none = register_pair(scan_of(relief, {.noise_mm = 0.02, .seed = 52}),
                                        scan_of(relief, {.offset = 0.4, .noise_mm = 0.02, .seed = 53}), {});
  EXPECT_GT(none.staying, 0.99);
  EXPECT_EQ(none.misjudged.norm(), 0.0) << "a surface that stays says so";
}

TEST(RegisterPair, PointsNoisierThanTheyAreApartAreAveragedFirst) {
  const PointCloud target = scan_of(relief, {.size = 250, .noise_mm = 0.8, .seed = 40}),
                   source = scan_of(relief, {.size = 250, .offset = 0.4, .noise_mm = 0.8, .seed = 41});
  const PairRegistration found = register_pair(target, source, motion(Vec3(1, 0, 1), 3.0, Vec3(1, 1, 1)));
  EXPECT_EQ(found.status, RegistrationStatus::Converged);
  EXPECT_LT(largest_gap(source, found.target_from_source, {}), 0.15) << "a fifth of the noise, from 62,500 points";
}

TEST(RegisterPair, BadScansAreRefusedAndStopIsHeeded) {
  const PointCloud good = scan_of(relief, {.size = 40});
  PointCloud few = good, same = good;
  few.points.resize(5);
  for (Vec3& p : same.points) p = Vec3(1, 2, 3);
  EXPECT_THROW((void)register_pair(good, few, {}), InvalidInput);
  EXPECT_THROW((void)register_pair(good, same, {}), InvalidInput);
  EXPECT_THROW((void)register_pair(good, PointCloud{}, {}), InvalidInput);
  EXPECT_THROW((void)register_pair(good, good, {}, {.min_overlap = 0.0}), InvalidInput);
  std::stop_source stop;
  stop.request_stop();
  RunControl control;
  control.stop = stop.get_token();
  EXPECT_THROW((void)register_pair(good, good, {}, {}, control), Canceled);
}

TEST(RotationSearch, SixtyRotationsLeaveNoneFartherThanFortyFiveDegrees) {
  const auto rotations = icosahedral_rotations();
  ASSERT_EQ(rotations.size(), 60u);
  double farthest = 0.0;
  for (std::uint64_t k = 0; k < 3000; ++k) {
    RandomStream random(3, k);
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
    double nearest = 180.0;
    for (const Eigen::Matrix3d& r : rotations) nearest = std::min(nearest, angle_between_deg(r, q.toRotationMatrix()));
    farthest = std::max(farthest, nearest);
  }
  EXPECT_LT(farthest, 44.5);
}

}  // namespace
}  // namespace patinate::capture
