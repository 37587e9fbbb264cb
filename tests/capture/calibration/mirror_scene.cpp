#include "tests/capture/calibration/mirror_scene.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace patinate::testing_support {

MirrorScene four_spheres() {
  CameraParameters p;
  p.width = 2448, p.height = 2048;
  p.fx = 2400, p.fy = 2410, p.cx = 1230, p.cy = 1020;
  p.distortion = {-0.12, 0.05, 4e-4, -3e-4, 0.0};
  // From above the table (world z up): z of the camera points down, tilted a little.
  p.rotation = Eigen::AngleAxisd(0.2, Vec3::UnitX()).toRotationMatrix() *
               Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()).toRotationMatrix();
  p.translation = {0, 0, 600};
  return {Camera(p), {{-120, -80, 40}, {120, -80, 40}, {-120, 80, 40}, {120, 80, 40}}, 40.0};
}

Vec2 highlight_of(const Camera& camera, const Vec3& center, double radius, const Vec3& light, bool is_distant) {
  const Vec3 to_eye = (camera.center() - center).normalized();
  const Vec3 to_light = is_distant ? light.normalized() : Vec3((light - center).normalized());
  const Vec3 turn = to_eye.cross(to_light).normalized();
  const double whole = std::atan2(to_eye.cross(to_light).norm(), to_eye.dot(to_light));
  const auto normal_at = [&](double angle) { return Vec3(Eigen::AngleAxisd(angle, turn) * to_eye); };
  // Angle of incidence less angle of reflection, which rises along the arc.
  const auto excess = [&](double angle) {
    const Vec3 n = normal_at(angle), point = center + radius * n;
    const Vec3 e = (camera.center() - point).normalized(),
               l = is_distant ? to_light : Vec3((light - point).normalized());
    return std::acos(n.dot(e)) - std::acos(n.dot(l));
  };
  double low = 0.0, high = whole;
  for (int i = 0; i < 200; ++i) (excess(0.5 * (low + high)) < 0 ? low : high) = 0.5 * (low + high);
  return *camera.project(center + radius * normal_at(0.5 * (low + high)));
}

std::vector<Vec2> outline_of(const Camera& camera, const Vec3& center, double radius, int count, double sigma,
                             RandomStream& random) {
  const Vec3 axis = center - camera.center();
  const double distance = axis.norm();
  const Vec3 u = axis.unitOrthogonal(), v = axis.normalized().cross(u);
  // The circle where rays touch: nearer to the camera than the center by radius^2 / distance.
  const double nearer = radius * radius / distance,
               rim = radius * std::sqrt(1.0 - radius * radius / (distance * distance));
  std::vector<Vec2> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / count;
    const Vec3 p = center - nearer * axis / distance + rim * (std::cos(angle) * u + std::sin(angle) * v);
    points.push_back(*camera.project(p) + sigma * Vec2(random.normal(), random.normal()));
  }
  return points;
}

std::vector<capture::MirrorSphere> spheres_of(const MirrorScene& scene, int count, double sigma, RandomStream& random) {
  std::vector<capture::MirrorSphere> spheres;
  for (const Vec3& center : scene.centers) {
    spheres.push_back({.radius_mm = scene.radius_mm,
                       .outline_px = outline_of(scene.camera, center, scene.radius_mm, count, sigma, random),
                       .name = ""});
  }
  return spheres;
}

ImageF photograph_of(const MirrorScene& scene, const std::vector<Vec3>& lights, double light_radius, double noise,
                     std::uint64_t seed) {
  const CameraParameters& p = scene.camera.parameters();
  ImageF photo(p.width, p.height, 1, 0.1f);
  const auto sphere_hit = [](const Vec3& origin, const Vec3& direction, const Vec3& center,
                             double radius) -> std::optional<double> {
    const double along = (center - origin).dot(direction);
    const double half = radius * radius - (center - origin - along * direction).squaredNorm();
    if (half < 0 || along < 0) return std::nullopt;
    return along - std::sqrt(half);
  };
  for (const Vec3& center : scene.centers) {
    const Vec2 middle = *scene.camera.project(center);
    const int reach = static_cast<int>(1.3 * p.fx * scene.radius_mm / (scene.camera.center() - center).norm());
    for (int y = static_cast<int>(middle.y()) - reach; y <= static_cast<int>(middle.y()) + reach; ++y) {
      for (int x = static_cast<int>(middle.x()) - reach; x <= static_cast<int>(middle.x()) + reach; ++x) {
        if (!photo.contains(x, y)) continue;
        double sum = 0.0;
        for (int k = 0; k < 9; ++k) {
          const auto ray = scene.camera.ray({x + (k % 3 - 1) / 3.0, y + (k / 3 - 1) / 3.0});
          double value = 0.1;
          if (const auto t = sphere_hit(ray->origin, ray->direction, center, scene.radius_mm)) {
            const Vec3 point = ray->origin + *t * ray->direction, n = (point - center) / scene.radius_mm;
            const Vec3 mirrored = ray->direction - 2.0 * ray->direction.dot(n) * n;
            value = mirrored.z() > 0 ? 0.02 + 0.06 * mirrored.z() : 0.1;
            for (const Vec3& light : lights) {
              if (sphere_hit(point, mirrored, light, light_radius)) value = 1.0;
            }
          }
          sum += value / 9.0;
        }
        photo.at(x, y) = static_cast<float>(sum);
      }
    }
  }
  for (int y = 0; y < p.height; ++y) {
    RandomStream random(seed, static_cast<std::uint64_t>(y), 7);
    for (int x = 0; x < p.width; ++x)
      photo.at(x, y) = std::max(0.0f, photo.at(x, y) + static_cast<float>(noise * random.normal()));
  }
  return photo;
}

}  // namespace patinate::testing_support
