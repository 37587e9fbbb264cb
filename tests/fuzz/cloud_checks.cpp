#include "tests/fuzz/cloud_checks.h"

#include "libcommon/geometry/scan_mesh.h"
#include "patinate/mesh_files/point_cloud_io.h"

namespace patinate::fuzz {

void read_and_check_cloud(const std::string& name, Bytes bytes) {
  const PointCloud cloud = read_point_cloud(fuzz_file(name, bytes));
  const int n = cloud.num_points();
  require(n > 0, "a scan has points");
  for (const Vec3& p : cloud.points) require(p.allFinite(), "points are finite");
  require(cloud.normals.empty() || cloud.normals.size() == cloud.points.size(), "a normal for every point, or none");
  require(cloud.colors.empty() || cloud.colors.size() == cloud.points.size(), "a color for every point, or none");
  for (const Triangle& t : cloud.triangles) {
    for (const int corner : t) require(corner >= 0 && corner < n, "corners are points");
  }
  if (cloud.grid) {
    require(cloud.grid->cell.size() ==
                static_cast<std::size_t>(cloud.grid->width) * static_cast<std::size_t>(cloud.grid->height),
            "a cell for every place");
    for (const int cell : cloud.grid->cell) require(cell >= -1 && cell < n, "cells are points or empty");
  }
  (void)mesh_of_scan(cloud);
}

}  // namespace patinate::fuzz
