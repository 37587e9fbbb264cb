#include "libcommon/geometry/scan_mesh.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "patinate/core/error.h"
#include "patinate/mesh_files/point_cloud_io.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

/// Heights over a grid of unit steps, rows going down (y falls), so that cells wind the other way than faces should.
PointCloud grid_cloud(int width, int height, const std::function<double(int, int)>& z) {
  PointCloud cloud;
  cloud.grid = PointCloud::Grid{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      cloud.grid->cell.push_back(cloud.num_points());
      cloud.points.emplace_back(x, -y, z(x, y));
    }
  }
  cloud.toward_scanner = Vec3(0, 0, 1);
  return cloud;
}

TEST(ScanMesh, AFlatGridIsItsAreaAndFacesTheScanner) {
  const Mesh mesh = mesh_of_scan(grid_cloud(4, 3, [](int, int) { return 0.0; }));
  EXPECT_EQ(mesh.num_triangles(), 2 * 3 * 2);
  Vec3 area = Vec3::Zero();
  for (int t = 0; t < mesh.num_triangles(); ++t) area += 0.5 * area_vector(mesh, t);
  EXPECT_NEAR((area - Vec3(0, 0, 3 * 2)).norm(), 0.0, 1e-12);
}

TEST(ScanMesh, NoTriangleSpansADepthJump) {
  // A step of 5.1 times the median edge between columns 2 and 3 is cut; one of 4.8 is not.
  const Mesh cut = mesh_of_scan(grid_cloud(6, 5, [](int x, int) { return x > 2 ? -5.1 : 0.0; }));
  EXPECT_EQ(cut.num_triangles(), 2 * 4 * 4);
  const Mesh whole = mesh_of_scan(grid_cloud(6, 5, [](int x, int) { return x > 2 ? -4.7 : 0.0; }));
  EXPECT_EQ(whole.num_triangles(), 2 * 5 * 4);
}

TEST(ScanMesh, AHoleLosesItsCornerOnly) {
  PointCloud cloud = grid_cloud(3, 3, [](int, int) { return 0.0; });
  cloud.grid->cell[0] = -1;
  EXPECT_EQ(mesh_of_scan(cloud).num_triangles(), 2 * 4 - 1);
}

TEST(ScanMesh, FacesOfAFileStayAsTheyAre) {
  PointCloud cloud;
  cloud.points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  cloud.triangles = {{0, 2, 1}};
  EXPECT_EQ(mesh_of_scan(cloud).triangles, cloud.triangles);
}

TEST(ScanMesh, LoosePointsAreRefusedWithWhatIsNeeded) {
  PointCloud cloud;
  cloud.points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  try {
    (void)mesh_of_scan(cloud);
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find("a grid or faces are needed"), std::string::npos);
  }
}

TEST(ScanMesh, ARealRangeGridFacesItsScannerEverywhere) {
  PATINATE_REQUIRE_DATA(path, "scans/bunny/data/bun000.ply");
  const PointCloud cloud = read_point_cloud(path);
  const Mesh mesh = mesh_of_scan(cloud);
  EXPECT_GT(mesh.num_triangles(), cloud.num_points()) << "almost two a point";
  int towards = 0;
  for (int t = 0; t < mesh.num_triangles(); ++t) towards += area_vector(mesh, t).z() > 0.0 ? 1 : 0;
  EXPECT_GT(towards, 0.995 * mesh.num_triangles());
}

}  // namespace
}  // namespace patinate
