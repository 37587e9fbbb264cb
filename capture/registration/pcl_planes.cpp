#include <pcl/features/normal_3d.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>

#include "capture/registration/pcl_alignment.inl"

namespace patinate::capture {

namespace {

void add_normals(const pcl::PointCloud<pcl::PointNormal>::Ptr& cloud, int num_neighbors) {
  pcl::NormalEstimation<pcl::PointNormal, pcl::PointNormal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointNormal>>());
  estimation.setKSearch(num_neighbors);
  estimation.compute(*cloud);
}

}  // namespace

std::array<float, 16> align_planes(const PclTask& task) {
  const auto target = pcl_cloud<pcl::PointNormal>(task.target), source = pcl_cloud<pcl::PointNormal>(task.source);
  add_normals(target, task.num_neighbors);
  add_normals(source, task.num_neighbors);
  pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
  return run_pcl<pcl::PointNormal>(icp, target, source, task);
}

}  // namespace patinate::capture
