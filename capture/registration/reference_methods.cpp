#include "capture/registration/reference_methods.h"

#include <pcl/features/normal_3d.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>

#include "capture/registration/prepared_scan.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr int kNeighbors = 20;

/// About its middle, in units of the scans' common scale: PCL's coordinates are floats.
template <class Point>
typename pcl::PointCloud<Point>::Ptr pcl_cloud(const PointCloud& cloud, const PreparedScan& scan) {
  auto result = std::make_shared<pcl::PointCloud<Point>>();
  result->reserve(cloud.points.size());
  for (const Vec3& p : cloud.points) {
    Point q;
    q.getVector3fMap() = ((p - scan.middle()) / scan.scale()).cast<float>();
    result->push_back(q);
  }
  return result;
}

void add_normals(const pcl::PointCloud<pcl::PointNormal>::Ptr& cloud) {
  pcl::NormalEstimation<pcl::PointNormal, pcl::PointNormal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointNormal>>());
  estimation.setKSearch(kNeighbors);
  estimation.compute(*cloud);
}

template <class Icp, class Point>
RigidTransform run(Icp& icp, const typename pcl::PointCloud<Point>::Ptr& target,
                   const typename pcl::PointCloud<Point>::Ptr& source, const RigidTransform& start, double gate,
                   int max_iterations) {
  icp.setInputTarget(target);
  icp.setInputSource(source);
  icp.setMaxCorrespondenceDistance(gate);
  icp.setMaximumIterations(max_iterations);
  icp.setTransformationEpsilon(1e-10);
  pcl::PointCloud<Point> moved;
  icp.align(moved, start.matrix().cast<float>());
  RigidTransform found;
  const Eigen::Matrix4d matrix = icp.getFinalTransformation().template cast<double>();
  if (!matrix.allFinite()) return start;
  return rigid_transform(matrix);
}

}  // namespace

PairRegistration register_pair_with_pcl(const PointCloud& target, const PointCloud& source, const RigidTransform& start,
                                        const RegistrationOptions& options, const RunControl& control) {
  if (options.method == RegistrationMethod::Symmetric)
    throw InvalidInput("register_pair_with_pcl: the symmetric method is not PCL's");
  const std::array<PointCloud, 2> both{target, source};
  const std::vector<PreparedScan> scans = prepare_scans(both, options, control);
  control.throw_if_stopped();
  const double gate = kReferenceGate * scans[0].fine().distance();
  const RigidTransform from = normalized(start, scans[0], scans[1]);
  RigidTransform found;
  if (options.method == RegistrationMethod::PclPlane) {
    const auto a = pcl_cloud<pcl::PointNormal>(target, scans[0]), b = pcl_cloud<pcl::PointNormal>(source, scans[1]);
    add_normals(a);
    add_normals(b);
    pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
    found = run<decltype(icp), pcl::PointNormal>(icp, a, b, from, gate, options.max_iterations);
  } else {
    const auto a = pcl_cloud<pcl::PointXYZ>(target, scans[0]), b = pcl_cloud<pcl::PointXYZ>(source, scans[1]);
    if (options.method == RegistrationMethod::PclPoint) {
      pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
      found = run<decltype(icp), pcl::PointXYZ>(icp, a, b, from, gate, options.max_iterations);
    } else {
      pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
      found = run<decltype(icp), pcl::PointXYZ>(icp, a, b, from, gate, options.max_iterations);
    }
  }
  return judge_pose(scans[0], scans[1], in_unit(found, scans[0], scans[1]), options, control);
}

}  // namespace patinate::capture
