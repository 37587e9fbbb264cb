/// \file
/// What the sources of the module `patinate-pcl` share.
/// Included after PCL. PCL's methods are compiled in three: together, they take 1.4 GB of memory.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "capture/registration/pcl_module.h"

namespace patinate::capture {

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

template <class Point, class Icp>
std::array<float, 16> run_pcl(Icp& icp, const typename pcl::PointCloud<Point>::Ptr& target,
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

/// Estimates each point's normal from its neighbors. @param num_neighbors  > 0.
void add_normals(const pcl::PointCloud<pcl::PointNormal>::Ptr& cloud, int num_neighbors);

/// PclTask::Method::Plane. @returns as PclModule::align().
[[nodiscard]] std::array<float, 16> align_planes(const PclTask& task);

}  // namespace patinate::capture
