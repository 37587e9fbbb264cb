#include <pcl/point_types.h>
#include <pcl/registration/icp.h>

#include "capture/registration/pcl_alignment.inl"

namespace patinate::capture {

std::array<float, 16> align_planes(const PclTask& task) {
  const auto target = pcl_cloud<pcl::PointNormal>(task.target), source = pcl_cloud<pcl::PointNormal>(task.source);
  add_normals(target, task.num_neighbors);
  add_normals(source, task.num_neighbors);
  pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
  return run_pcl<pcl::PointNormal>(icp, target, source, task);
}

}  // namespace patinate::capture
