#include "patinate/geometry/point_cloud.h"

namespace patinate {

void scale_cloud(PointCloud& cloud, double factor) {
  for (Vec3& p : cloud.points) p *= factor;
  if (cloud.scanner) *cloud.scanner *= factor;
}

Box bounding_box(const PointCloud& cloud) {
  Box box;
  for (const Vec3& p : cloud.points) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

std::optional<Vec3> direction_to_scanner(const PointCloud& cloud, const Vec3& point) {
  if (!cloud.scanner) return cloud.toward_scanner;
  const Vec3 to = *cloud.scanner - point;
  return to.norm() > 0.0 ? std::optional<Vec3>(to.normalized()) : std::nullopt;
}

PointCloud moved(PointCloud cloud, const RigidTransform& target_from_cloud) {
  for (Vec3& p : cloud.points) p = target_from_cloud.apply(p);
  for (Vec3& n : cloud.normals) n = target_from_cloud.rotation * n;
  if (cloud.scanner) cloud.scanner = target_from_cloud.apply(*cloud.scanner);
  if (cloud.toward_scanner) cloud.toward_scanner = target_from_cloud.rotation * *cloud.toward_scanner;
  return cloud;
}

}  // namespace patinate
