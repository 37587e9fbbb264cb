#include "capture/registration/joint_registration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "capture/registration/pose_graph.h"
#include "capture/registration/reference_methods.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/capture/registration/scan_shapes.h"

namespace patinate::capture {
namespace {

using testing_support::largest_gap;
using testing_support::mirrored;
using testing_support::part_of;
using testing_support::relief;
using testing_support::scan_of;

RigidTransform random_motion(std::uint64_t item, double angle_deg, double shift) {
  RandomStream random(77, item);
  const Vec3 axis(random.normal(), random.normal(), random.normal()),
      by(random.normal(), random.normal(), random.normal());
  return {rotation_of(axis.normalized() * (angle_deg * 3.14159265358979 / 180.0)), shift * by.normalized()};
}

struct Steps {
  std::vector<PointCloud> scans;
  std::vector<RigidTransform> truth;  ///< first scan from scan.
};
/// Strips of the relief, each with noise of its own, each moved.
Steps strips(int count, double angle_deg) {
  Steps steps;
  for (int k = 0; k < count; ++k) {
    const double low = -50.0 + 40.0 * k / (count - 1), high = low + 60.0;
    const auto seed = static_cast<std::uint64_t>(60 + k);
    const PointCloud part = part_of(scan_of(relief, {.size = 90, .offset = 0.2 * k, .noise_mm = 0.05, .seed = seed}),
                                    [&](const Vec3& p) { return p.x() >= low && p.x() <= high; });
    const RigidTransform motion = k == 0 ? RigidTransform{} : random_motion(seed, angle_deg, 20.0);
    steps.scans.push_back(moved(part, motion));
    steps.truth.push_back(motion.inverse());
  }
  return steps;
}

TEST(PoseGraph, ConsistentEdgesGiveBackThePoses) {
  std::vector<RigidTransform> truth, start;
  for (std::uint64_t k = 0; k < 5; ++k) {
    truth.push_back(random_motion(k, 40.0 * static_cast<double>(k), 3.0));
    start.push_back(random_motion(100 + k, 5.0, 0.2) * truth.back());
  }
  start[2] = truth[2];
  std::vector<PoseEdge> edges;
  for (const auto& [i, j] : {std::pair{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 0}, {0, 2}}) {
    edges.push_back({i, j, truth[i].inverse() * truth[j], Matrix6::Identity()});
  }
  const auto found = solve_poses(start, edges, 2);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR((found[k].rotation - truth[k].rotation).norm(), 0.0, 1e-9);
    EXPECT_NEAR((found[k].translation - truth[k].translation).norm(), 0.0, 1e-9);
  }
}

TEST(PoseGraph, ALoopSharesItsErrorByInformation) {
  // Three poses on a line, 1 and 1 apart by two edges, 2.3 by the third: least squares puts 0.1 on each edge of equal
  // weight.
  std::vector<PoseEdge> edges;
  const auto at = [](double x) { return RigidTransform{Eigen::Matrix3d::Identity(), Vec3(x, 0, 0)}; };
  edges.push_back({0, 1, at(1.0), Matrix6::Identity()});
  edges.push_back({1, 2, at(1.0), Matrix6::Identity()});
  edges.push_back({0, 2, at(2.3), Matrix6::Identity()});
  const auto found = solve_poses(std::vector<RigidTransform>{at(0), at(1), at(2)}, edges, 0);
  EXPECT_NEAR(found[1].translation.x(), 1.1, 1e-9);
  EXPECT_NEAR(found[2].translation.x(), 2.2, 1e-9);
  // One way around has information 1, the other 1/2: together 3/2.
  const auto covariances = pose_covariances(found, edges, 0);
  EXPECT_NEAR(covariances[2](3, 3), 2.0 / 3.0, 1e-9);
  EXPECT_EQ(covariances[0].norm(), 0.0);
}

TEST(RegisterJointly, StepsMovedAnyhowComeBackIntoTheReferencesFrame) {
  const Steps steps = strips(4, 130.0);
  const JointRegistration found = register_jointly(steps.scans, {}, 0);
  for (std::size_t k = 0; k < steps.scans.size(); ++k) {
    EXPECT_EQ(found.scans[k].status, RegistrationStatus::Converged) << k;
    // 0.05 mm of noise over some thousand points.
    EXPECT_LT(largest_gap(steps.scans[k], found.scans[k].reference_from_scan, steps.truth[k]), 0.05) << k;
  }
  EXPECT_GT(found.edges.size(), 3u) << "more than a chain";
  EXPECT_LT(found.largest_closure, 0.1) << "pairs of which a third overlaps close their loops to twice the noise";
}

TEST(RegisterJointly, AnyScanCanBeTheReference) {
  const Steps steps = strips(3, 20.0);
  std::vector<std::optional<RigidTransform>> initial;
  for (std::size_t k = 0; k < 3; ++k) initial.emplace_back(random_motion(k, 3.0, 1.0) * steps.truth[k]);
  const JointRegistration first = register_jointly(steps.scans, initial, 0),
                          last = register_jointly(steps.scans, initial, 2);
  const RigidTransform last_from_first = last.scans[0].reference_from_scan;
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(last.scans[k].status, RegistrationStatus::Converged);
    // Both settle where nothing moves by more than 1e-7 of the size.
    EXPECT_LT(largest_gap(steps.scans[k], last.scans[k].reference_from_scan,
                          last_from_first * first.scans[k].reference_from_scan),
              1e-3)
        << k;
  }
}

TEST(RegisterJointly, AStepThatFitsNoneSaysSoAndTheOthersStand) {
  Steps steps = strips(3, 15.0);
  steps.scans[1] = mirrored(steps.scans[1]);
  steps.scans.push_back(steps.scans[2]);
  const JointRegistration found = register_jointly(steps.scans, {}, 2);
  EXPECT_NE(found.scans[1].status, RegistrationStatus::Converged);
  EXPECT_EQ(found.scans[3].status, RegistrationStatus::Converged);
  EXPECT_LT(largest_gap(steps.scans[3], found.scans[3].reference_from_scan, {}), 1e-9) << "the same scan twice";
}

TEST(RegisterJointly, AScanMostOfWhichHasGrownIsNotPlacedThroughItsNeighbors) {
  // Growth spreads from one side and rises. Neighbors in time fit, the last scans and the reference do not.
  constexpr std::array<double, 4> kShare{0.0, 0.4, 0.8, 0.9}, kHeight_mm{0.0, 0.5, 1.0, 1.4};
  std::vector<PointCloud> scans;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto grown = [share = kShare[k], height = kHeight_mm[k]](double x, double y) {
      const double u = std::clamp(((x + 50.0) / 100.0 - (1.0 - share)) / 0.3, 0.0, 1.0);
      return relief(x, y) + height * u * (1.0 + 0.2 * std::sin(0.3 * y));
    };
    scans.push_back(scan_of(grown, {.offset = 0.2 * static_cast<double>(k), .noise_mm = 0.02, .seed = 300 + k}));
  }
  const JointRegistration found = register_jointly(scans, {}, 0);
  EXPECT_EQ(found.scans[1].status, RegistrationStatus::Converged) << "less than half has grown";
  EXPECT_FALSE(found.scans[1].is_misled);
  for (const std::size_t k : {2u, 3u}) {
    EXPECT_LT(found.scans[k].staying, 0.4) << k;
    EXPECT_EQ(found.scans[k].status, RegistrationStatus::PoorFit) << k;
    EXPECT_TRUE(found.scans[k].is_misled) << k;
    // Right order only, as for pairs (registration_test.cpp).
    const RigidTransform& pose = found.scans[k].reference_from_scan;
    const double off = (found.scans[k].center - pose.inverse().apply(found.scans[k].center)).norm();
    EXPECT_LT(off, 3.0 * std::sqrt(found.scans[k].covariance.bottomRightCorner<3, 3>().trace())) << k;
  }
}

TEST(RegisterJointly, OneScanOrABadReferenceIsRefused) {
  const PointCloud scan = scan_of(relief, {.size = 40});
  const std::vector<PointCloud> one{scan}, two{scan, scan};
  EXPECT_THROW((void)register_jointly(one, {}, 0), InvalidInput);
  EXPECT_THROW((void)register_jointly(two, {}, 2), InvalidInput);
}

TEST(ReferenceMethods, PclComesCloseAndTheSymmetricMethodCloser) {
  const PointCloud target = scan_of(relief, {.size = 70, .noise_mm = 0.03, .seed = 90});
  const RigidTransform source_from_target = random_motion(1, 4.0, 1.0);
  const PointCloud source =
      moved(scan_of(relief, {.size = 70, .offset = 0.4, .noise_mm = 0.03, .seed = 91}), source_from_target);
  const auto gap = [&](const PairRegistration& r) {
    return largest_gap(target, r.target_from_source * source_from_target, {});
  };
  const double own = gap(register_pair(target, source, RigidTransform{}));
  EXPECT_LT(own, 0.02);
  for (const auto& [method, most] :
       {std::pair{RegistrationMethod::PclPlane, 0.2},
        {RegistrationMethod::PclGicp, 0.3},
        {RegistrationMethod::PclPoint, 2.0}}) {  // Point-to-point locks onto the grid, of 1.4 mm.
    const PairRegistration pcl = register_pair_with_pcl(target, source, RigidTransform{}, {.method = method});
    EXPECT_LT(gap(pcl), most) << static_cast<int>(method);
    EXPECT_LT(own, gap(pcl)) << static_cast<int>(method);
  }
}

}  // namespace
}  // namespace patinate::capture
