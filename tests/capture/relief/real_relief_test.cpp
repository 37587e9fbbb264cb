// Real scans of an object that did not change: what differs is the scanner.
#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "capture/relief/relief_change.h"
#include "patinate/mesh_files/point_cloud_io.h"
#include "tests/support/test_data.h"

namespace patinate::capture {
namespace {

TEST(RealHeightChange, OfARigidObjectAlmostNothingIsSignificant) {
  PATINATE_REQUIRE_DATA(folder, "scans/bunny");
  std::vector<PointCloud> scans;
  for (const char* name : {"data/bun000.ply", "data/bun045.ply"}) {
    scans.push_back(read_point_cloud(folder / name));
    scale_cloud(scans.back(), 1000.0);
  }
  std::ifstream file(folder / "derived_reference/ref_bun000_bun045.txt");
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) file >> matrix(i / 4, i % 4);
  const std::vector<RigidTransform> poses{RigidTransform{}, rigid_transform(matrix)};
  const ReliefChange change = measure_relief(scans, poses, 0, {}, {}).changes[0];
  EXPECT_GT(change.measured_share, 0.7);  // bun045 sees 0.86 of bun000's surface.
  // Seen from another side, noise and warping are others: at most as much is called changed as is by chance at the
  // level of 95 % of single places.
  EXPECT_LT(change.changed_share, 0.05);
  EXPECT_LT(std::abs(change.net.mm3), 4.0 * change.net.stddev_mm3);
}

}  // namespace
}  // namespace patinate::capture
