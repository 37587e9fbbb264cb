#include "patinate/mesh_files/point_cloud_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(scan_poses) {
  for (const ScanPose& pose : read_scan_poses(fuzz::fuzz_file("scans.conf", bytes))) {
    const Eigen::Matrix3d should_be_one = pose.world_from_scan.rotation.transpose() * pose.world_from_scan.rotation;
    fuzz::require(should_be_one.isApprox(Eigen::Matrix3d::Identity(), 1e-9), "a pose is a rotation");
    fuzz::require(pose.world_from_scan.translation.allFinite(), "poses are finite");
  }
}
