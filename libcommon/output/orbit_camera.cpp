#include "libcommon/output/orbit_camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "libcommon/output/sampling.h"

namespace patinate {

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

// Positions that triangles use, in the camera's axes.
std::vector<Vec3> points_in_camera(const Mesh& mesh, const OrbitCamera& camera) {
  std::vector<char> is_used(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.triangles) {
    for (const int i : t) is_used[i] = 1;
  }
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < is_used.size(); ++i) {
    const Vec3& p = mesh.positions[i];
    if (is_used[i] != 0) points.push_back({p.dot(camera.right), p.dot(camera.up), p.dot(camera.backward)});
  }
  return points;
}

// Smallest camera depth from which one axis fits: |x - cx| <= t (cz - z) for all points.
double fitting_depth(const std::vector<Vec3>& points, int axis, double t) {
  double high = -kInf, low = kInf;
  for (const Vec3& p : points) {
    high = std::max(high, p[axis] + t * p.z());
    low = std::min(low, p[axis] - t * p.z());
  }
  return (high - low) / (2.0 * t);
}

// Place of the camera along an axis from which the outline is centered: the largest and the smallest projection are
// opposite; their sum falls as the camera moves.
double centering_place(const std::vector<Vec3>& points, int axis, double depth) {
  double low = kInf, high = -kInf;
  for (const Vec3& p : points) {
    low = std::min(low, p[axis]);
    high = std::max(high, p[axis]);
  }
  for (int step = 0; step < 48; ++step) {
    const double middle = 0.5 * (low + high);
    double most = -kInf, least = kInf;
    for (const Vec3& p : points) {
      const double projected = (p[axis] - middle) / (depth - p.z());
      most = std::max(most, projected);
      least = std::min(least, projected);
    }
    (most + least > 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

OrbitCamera fitted_camera(const Mesh& mesh, const RenderOptions& o) {
  const double azimuth = radians(o.azimuth_deg), elevation = radians(o.elevation_deg);
  OrbitCamera camera;
  camera.backward = world_from_y_up(
      {std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth)}, o.up);
  camera.right = world_from_y_up({std::cos(azimuth), 0.0, -std::sin(azimuth)}, o.up);
  camera.up = camera.backward.cross(camera.right);
  const double t = std::tan(0.5 * radians(o.fov_deg));
  const double larger = std::max(o.width, o.height);
  camera.tan_x = t * o.width / larger;
  camera.tan_y = t * o.height / larger;

  const std::vector<Vec3> points = points_in_camera(mesh, camera);
  const double clearance = 1e-3 * bounding_box(mesh).diagonal();
  double z = -kInf;
  for (const Vec3& p : points) z = std::max(z, p.z() + clearance);
  z = std::max(z, fitting_depth(points, 0, camera.tan_x * (1.0 - o.margin)));
  z = std::max(z, fitting_depth(points, 1, camera.tan_y * (1.0 - o.margin)));
  camera.position =
      centering_place(points, 0, z) * camera.right + centering_place(points, 1, z) * camera.up + z * camera.backward;
  if (o.target || o.distance) {
    const Vec3 target = o.target.value_or(bounding_box(mesh).center());
    const double fitted = (camera.position - bounding_box(mesh).center()).dot(camera.backward);
    camera.position = target + o.distance.value_or(fitted) * camera.backward;
  }
  camera.tan_x /= o.zoom;
  camera.tan_y /= o.zoom;
  return camera;
}

}  // namespace patinate
