#include <pcl/features/normal_3d.h>
#include <pcl/point_types.h>

#include "capture/registration/pcl_alignment.inl"

namespace patinate::capture {

void add_normals(const pcl::PointCloud<pcl::PointNormal>::Ptr& cloud, int num_neighbors) {
  pcl::NormalEstimation<pcl::PointNormal, pcl::PointNormal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointNormal>>());
  estimation.setKSearch(num_neighbors);
  estimation.compute(*cloud);
}

}  // namespace patinate::capture
