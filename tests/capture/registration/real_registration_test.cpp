// Real scans: what goals.md asks of registration, in short; capture_benchmark measures all of it.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>

#include "capture/registration/joint_registration.h"
#include "libcommon/core/random.h"
#include "patinate/capture/registration.h"
#include "patinate/mesh_files/point_cloud_io.h"
#include "tests/support/test_data.h"

namespace patinate::capture {
namespace {

PointCloud bunny_scan(const std::filesystem::path& file) {
  PointCloud cloud = read_point_cloud(file);
  scale_cloud(cloud, 1000.0);
  return cloud;
}

TEST(RealRegistration, HalvesOfOneScanAreBroughtTogetherNearlyAsWellAsNoiseAllows) {
  PATINATE_REQUIRE_DATA(path, "scans/bunny/data/bun000.ply");
  const PointCloud scan = bunny_scan(path);
  constexpr int kRuns = 6;
  double angle = 0.0, shift = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(11, static_cast<std::uint64_t>(run));
    PointCloud target, source;
    target.toward_scanner = source.toward_scanner = scan.toward_scanner;
    for (const Vec3& p : scan.points) (random.uniform() < 0.5 ? target : source).points.push_back(p);
    const Vec3 axis = Vec3(random.normal(), random.normal(), random.normal()).normalized(),
               by = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    const Vec3 middle = bounding_box(scan).center();
    RigidTransform off{rotation_of(axis * (5.0 * 3.14159265358979 / 180.0)), Vec3::Zero()};
    off.translation = middle + 3.0 * by - off.rotation * middle;
    const PairRegistration found = register_pair(target, moved(source, off), RigidTransform{});
    ASSERT_EQ(found.status, RegistrationStatus::Converged);
    const RigidTransform error = found.target_from_source * off;
    angle += std::pow(angle_between_deg(error.rotation, Eigen::Matrix3d::Identity()), 2) / kRuns;
    shift += (error.apply(found.center) - found.center).squaredNorm() / kRuns;
  }
  // goals.md asks for 0.0029 deg and 2.3 um rms; of six runs the rms scatters by 1 / sqrt(2 * 6 * 3) = 17 %, here three
  // times that.
  EXPECT_LT(std::sqrt(angle), 0.0029 * 1.5);
  EXPECT_LT(std::sqrt(shift), 0.0023 * 1.5);
}

TEST(RealRegistration, OverlappingScansAreFoundFromAnywhereAndSwapped) {
  PATINATE_REQUIRE_DATA(folder, "scans/bunny");
  const PointCloud target = bunny_scan(folder / "data/bun000.ply"), source = bunny_scan(folder / "data/bun045.ply");
  std::ifstream file(folder / "derived_reference/ref_bun000_bun045.txt");
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) file >> matrix(i / 4, i % 4);
  const RigidTransform reference = rigid_transform(matrix);
  const PairRegistration found = register_pair(target, source, std::nullopt),
                         back = register_pair(source, target, found.target_from_source.inverse());
  ASSERT_EQ(found.status, RegistrationStatus::Converged);
  EXPECT_TRUE(found.is_found_by_search);
  // Two solvers reproduce this reference to 0.007 deg and 0.008 mm. These scans do not fit each other rigidly to better
  // than 0.1 mm, and where that goes depends on the weights: 0.05 deg is what estimators differ by.
  EXPECT_LT(angle_between_deg(found.target_from_source.rotation, reference.rotation), 0.05);
  const RigidTransform twice = back.target_from_source * found.target_from_source;
  EXPECT_LT(angle_between_deg(twice.rotation, Eigen::Matrix3d::Identity()), 0.005);
  EXPECT_LT((twice.apply(back.center) - back.center).norm(), 0.005);
}

TEST(RealRegistration, OppositeSidesAreNoFit) {
  PATINATE_REQUIRE_DATA(folder, "scans/bunny/data");
  const PairRegistration found =
      register_pair(bunny_scan(folder / "bun000.ply"), bunny_scan(folder / "bun180.ply"), std::nullopt);
  EXPECT_NE(found.status, RegistrationStatus::Converged);
  EXPECT_NE(found.status, RegistrationStatus::Degenerate);
}

// An object that has not changed, seen from all around: half of the scans share less than half with the reference.
TEST(RealRegistration, ScansFromAllAroundAreAllPlaced) {
  PATINATE_REQUIRE_DATA(folder, "scans/bunny/data");
  std::vector<PointCloud> scans;
  std::vector<std::optional<RigidTransform>> initial;
  for (const ScanPose& pose : read_scan_poses(folder / "bun.conf")) {
    scans.push_back(bunny_scan(pose.scan));
    initial.emplace_back(pose.world_from_scan);
    initial.back()->translation *= 1000.0;
  }
  const JointRegistration found = register_jointly(scans, initial, 0);
  for (std::size_t k = 0; k < scans.size(); ++k) {
    EXPECT_EQ(found.scans[k].status, RegistrationStatus::Converged) << k;
    EXPECT_FALSE(found.scans[k].is_misled) << k;
  }
}

}  // namespace
}  // namespace patinate::capture
