#include "capture/registration/reference_methods.h"

#include <algorithm>
#include <array>
#include <vector>

#include "capture/registration/pcl_module.h"
#include "capture/registration/prepared_scan.h"
#include "libcommon/core/module.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

PclModule& pcl_module() {
  using Entry = PclModule* (*)();
  static PclModule& module = *reinterpret_cast<Entry>(module_function("patinate-pcl", kPclEntry))();
  return module;
}

PclTask::Method method_of(RegistrationMethod method) {
  switch (method) {
    case RegistrationMethod::PclPlane:
      return PclTask::Method::Plane;
    case RegistrationMethod::PclPoint:
      return PclTask::Method::Point;
    case RegistrationMethod::PclGicp:
      return PclTask::Method::Generalized;
    case RegistrationMethod::Symmetric:
      break;
  }
  throw InvalidInput("register_pair_with_pcl: the symmetric method is not PCL's");
}

/// About its middle, in units of the scans' common scale: PCL's coordinates are floats.
std::vector<std::array<float, 3>> pcl_points(const PointCloud& cloud, const PreparedScan& scan) {
  std::vector<std::array<float, 3>> points;
  points.reserve(cloud.points.size());
  for (const Vec3& p : cloud.points) {
    const Eigen::Vector3f q = ((p - scan.middle()) / scan.scale()).cast<float>();
    points.push_back({q.x(), q.y(), q.z()});
  }
  return points;
}

}  // namespace

PairRegistration register_pair_with_pcl(const PointCloud& target, const PointCloud& source, const RigidTransform& start,
                                        const RegistrationOptions& options, const RunControl& control) {
  PclTask task;
  task.method = method_of(options.method);
  PclModule& pcl = pcl_module();
  const std::array<PointCloud, 2> both{target, source};
  const std::vector<PreparedScan> scans = prepare_scans(both, options, control);
  control.throw_if_stopped();
  task.target = pcl_points(target, scans[0]);
  task.source = pcl_points(source, scans[1]);
  task.gate = kReferenceGate * scans[0].fine().distance();
  task.max_iterations = options.max_iterations;
  const RigidTransform from = normalized(start, scans[0], scans[1]);
  const Eigen::Matrix4f first = from.matrix().cast<float>();
  std::copy_n(first.data(), task.start.size(), task.start.begin());
  const std::array<float, 16> values = pcl.align(task);
  const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix4f>(values.data()).cast<double>();
  const RigidTransform found = matrix.allFinite() ? rigid_transform(matrix) : from;
  return judge_pose(scans[0], scans[1], in_unit(found, scans[0], scans[1]), options, control);
}

}  // namespace patinate::capture
