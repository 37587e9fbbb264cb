// The module `patinate-pcl`: see pcl_module.h.
#include "capture/registration/pcl_module.h"

#include <pcl/features/normal_3d.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>

#include <algorithm>
#include <memory>

namespace patinate::capture {

namespace {

template <class Point>
typename pcl::PointCloud<Point>::Ptr pcl_cloud(const std::vector<std::array<float, 3>>& points) {
  auto result = std::make_shared<pcl::PointCloud<Point>>();
  result->reserve(points.size());
  for (const std::array<float, 3>& p : points) {
    Point q;
    q.getVector3fMap() = Eigen::Vector3f(p[0], p[1], p[2]);
    result->push_back(q);
  }
  return result;
}

void add_normals(const pcl::PointCloud<pcl::PointNormal>::Ptr& cloud, int num_neighbors) {
  pcl::NormalEstimation<pcl::PointNormal, pcl::PointNormal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointNormal>>());
  estimation.setKSearch(num_neighbors);
  estimation.compute(*cloud);
}

template <class Point, class Icp>
std::array<float, 16> run(Icp& icp, const typename pcl::PointCloud<Point>::Ptr& target,
                          const typename pcl::PointCloud<Point>::Ptr& source, const PclTask& task) {
  icp.setInputTarget(target);
  icp.setInputSource(source);
  icp.setMaxCorrespondenceDistance(task.gate);
  icp.setMaximumIterations(task.max_iterations);
  icp.setTransformationEpsilon(1e-10);
  pcl::PointCloud<Point> moved;
  icp.align(moved, Eigen::Map<const Eigen::Matrix4f>(task.start.data()));
  const Eigen::Matrix4f found = icp.getFinalTransformation();
  std::array<float, 16> matrix{};
  std::copy_n(found.data(), matrix.size(), matrix.begin());
  return matrix;
}

class Pcl final : public PclModule {
 public:
  [[nodiscard]] std::array<float, 16> align(const PclTask& task) override {
    if (task.method == PclTask::Method::Plane) {
      const auto target = pcl_cloud<pcl::PointNormal>(task.target), source = pcl_cloud<pcl::PointNormal>(task.source);
      add_normals(target, task.num_neighbors);
      add_normals(source, task.num_neighbors);
      pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
      return run<pcl::PointNormal>(icp, target, source, task);
    }
    const auto target = pcl_cloud<pcl::PointXYZ>(task.target), source = pcl_cloud<pcl::PointXYZ>(task.source);
    if (task.method == PclTask::Method::Point) {
      pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
      return run<pcl::PointXYZ>(icp, target, source, task);
    }
    pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
    return run<pcl::PointXYZ>(icp, target, source, task);
  }
};

}  // namespace

}  // namespace patinate::capture

extern "C" [[gnu::visibility("default")]] patinate::capture::PclModule* patinate_pcl_1() {
  static patinate::capture::Pcl module;
  return &module;
}
