#include "libcommon/geometry/point_cloud.h"

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

}  // namespace patinate
