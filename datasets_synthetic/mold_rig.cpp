// How the mold stands, is lit, is seen and is scanned.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets_synthetic/mold.h"
#include "datasets_synthetic/posed_camera.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/geometry/ray_scene.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kMotion = 201;  // Purposes of random streams.
constexpr std::uint32_t kLights = 202;
constexpr std::uint32_t kDrift = 203;
constexpr std::uint32_t kScanNoise = 204;
constexpr double kJump = 6.0;  ///< Longest edge of a scan's triangles, in spacings.
constexpr std::int64_t kRigRows = 8;

Camera mold_camera(const MoldOptions& o) {
  // Above, a little in front; the mold fills most of the picture's height, and the card stands beside it.
  const double radius = o.radius_mm;
  const Vec3 eye(0.25 * radius, -2.4 * radius, 6.6 * radius), target(0.25 * radius, -0.03 * radius, 0.05 * radius);
  CameraParameters p = posed_camera(eye, target, o.width, o.height);
  const double distance = (eye - target).norm();
  p.fx = p.fy = std::min(o.height / 2.30, o.width / 3.05) * distance / radius;
  p.distortion = {-0.09, 0.04, 0.0004, -0.0003, 0.0};
  return Camera(p);
}

std::vector<Light> mold_lights(const MoldOptions& o) {
  std::vector<Light> lights;
  for (int i = 0; i < o.num_lights; ++i) {
    RandomStream random(static_cast<std::uint64_t>(o.seed), static_cast<std::uint64_t>(i), kLights);
    const double azimuth = 2.0 * std::numbers::pi * (i + 0.35 + 0.1 * random.uniform()) / o.num_lights;
    const double elevation = (i % 2 == 0 ? 0.95 : 0.72) + 0.08 * random.uniform(),
                 distance = o.radius_mm * (5.6 + 1.2 * random.uniform());
    Light light;
    light.position = distance * Vec3(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                     std::sin(elevation));
    light.intensity =
        1.25 * std::numbers::pi * distance * distance * (0.95 + 0.1 * random.uniform()) * Vec3(1.0, 0.97, 0.91);
    lights.push_back(light);
  }
  return lights;
}

RigidTransform mold_motion(const MoldOptions& o, int step) {
  if (step == 0) return {};
  RandomStream random(static_cast<std::uint64_t>(o.seed), static_cast<std::uint64_t>(step), kMotion);
  const auto within = [&] { return 2.0 * random.uniform() - 1.0; };
  RigidTransform motion;
  // It stays on the table, more or less: turned about the vertical, tilted a third of that.
  const double turn = within(), tilt_x = within(), tilt_y = within();
  const double degree = std::numbers::pi / 180.0;
  motion.rotation = rotation_of(o.motion_deg * degree * turn * Vec3::UnitZ()) *
                    rotation_of(o.motion_deg * degree / 3.0 * Vec3(tilt_x, tilt_y, 0.0));
  const double x = within(), y = within(), z = within();
  motion.translation = o.motion_mm * Vec3(x, y, 0.3 * z);
  return motion;
}

}  // namespace

MoldRig mold_rig(const MoldOptions& o) {
  MoldRig rig{.camera = mold_camera(o), .lights = mold_lights(o), .scanner_from_object = {}, .gains = {}, .card = {}};
  for (int step = 0; step < o.num_steps; ++step) {
    rig.scanner_from_object.push_back(mold_motion(o, step));
    RandomStream random(static_cast<std::uint64_t>(o.seed), static_cast<std::uint64_t>(step), kDrift);
    Vec3 gain = Vec3::Ones();
    const double exposure = random.normal();
    for (int c = 0; c < 3; ++c) gain[c] += step == 0 ? 0.0 : o.drift * (exposure + 0.4 * random.normal());
    rig.gains.push_back(gain.cwiseMax(0.1));
  }
  rig.table_mm = -0.12 * o.radius_mm -
                 std::sin(std::min(o.motion_deg / 3.0, 60.0) * std::numbers::pi / 180.0) * 1.5 * o.radius_mm -
                 0.5 * o.motion_mm;
  rig.card.low = o.radius_mm * Vec3(1.33, -0.62, 0.0);
  rig.card.high = o.radius_mm * Vec3(1.63, -0.32, 0.0);
  return rig;
}

std::vector<Vec2> card_polygon(const MoldRig& rig) {
  std::vector<Vec2> polygon;
  const Vec3 middle = rig.card.center(), half = 0.5 * (rig.card.high - rig.card.low);
  for (const Vec2& corner : {Vec2(-1, 1), Vec2(1, 1), Vec2(1, -1), Vec2(-1, -1)}) {
    const Vec3 p(middle.x() + 0.75 * corner.x() * half.x(), middle.y() + 0.75 * corner.y() * half.y(), rig.table_mm);
    polygon.push_back(rig.camera.project(p).value());
  }
  return polygon;
}

PointCloud mold_scan(const Mold& mold, const MoldRig& rig, int step, const RunControl& control) {
  const MoldOptions& o = mold.options();
  const RigidTransform& motion = rig.scanner_from_object[step];
  const RigidTransform back = motion.inverse();
  // From the mesh a start, then the height function itself.
  const double time_d = step * o.interval_d;
  Mesh rough = mold.mesh(o.radius_mm / 80.0, time_d);
  for (Vec3& p : rough.positions) p = motion.apply(p);
  const RayScene scene(rough);
  const Box box = bounding_box(rough);
  const double spacing = o.scan_spacing_mm, top = box.high.z() + o.radius_mm;
  const int x0 = static_cast<int>(std::ceil(box.low.x() / spacing)),
            x1 = static_cast<int>(std::floor(box.high.x() / spacing));
  const int y0 = static_cast<int>(std::ceil(box.low.y() / spacing)),
            y1 = static_cast<int>(std::floor(box.high.y() / spacing));
  const int width = x1 - x0 + 1, height = y1 - y0 + 1;
  Image<double> z(width, height);
  ImageU8 seen(width, height);
  parallel_for(height, kRigRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int row = static_cast<int>(begin); row < static_cast<int>(end); ++row) {
      for (int column = 0; column < width; ++column) {
        const Vec3 from((x0 + column) * spacing, (y1 - row) * spacing, top);
        const std::optional<RayHit> hit = scene.first_hit(from, -Vec3::UnitZ());
        if (!hit) continue;
        double depth = hit->distance;
        const Vec3 direction = back.rotation * -Vec3::UnitZ();
        for (int i = 0; i < 8; ++i) {  // Newton on z(x, y) along the ray.
          const Vec3 p = back.apply(from - depth * Vec3::UnitZ());
          const Vec3 n = mold.normal(p.x(), p.y(), time_d);
          depth -= (p.z() - mold.height(p.x(), p.y(), time_d)) * n.z() / std::min(-1e-3, direction.dot(n));
        }
        const Vec3 p = back.apply(from - depth * Vec3::UnitZ());
        if (!(std::hypot(p.x(), p.y()) <= o.radius_mm) || !(std::abs(depth - hit->distance) < 0.05 * o.radius_mm))
          continue;
        RandomStream random(
            static_cast<std::uint64_t>(o.seed),
            static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(width) + static_cast<std::uint64_t>(column),
            kScanNoise + 16u * static_cast<std::uint32_t>(step));
        z.at(column, row) = top - depth + (o.scan_noise_mm > 0.0 ? o.scan_noise_mm * random.normal() : 0.0);
        seen.at(column, row) = 255;
      }
    }
  });
  PointCloud scan;
  Image<int> index(width, height, 1, -1);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      if (seen.at(column, row) == 0) continue;
      index.at(column, row) = static_cast<int>(scan.points.size());
      scan.points.emplace_back((x0 + column) * spacing, (y1 - row) * spacing, z.at(column, row));
      if (o.scan_noise_mm > 0.0) continue;
      const Vec3 p = back.apply(scan.points.back());
      scan.normals.push_back(motion.rotation * mold.normal(p.x(), p.y(), time_d));
    }
  }
  const auto add = [&](int a, int b, int c) {
    if (a < 0 || b < 0 || c < 0) return;
    const auto at = [&](int i) -> const Vec3& { return scan.points[i]; };
    const double longest = std::max({(at(a) - at(b)).norm(), (at(b) - at(c)).norm(), (at(c) - at(a)).norm()});
    if (longest < kJump * spacing) scan.triangles.push_back({a, b, c});
  };
  for (int row = 0; row + 1 < height; ++row) {
    for (int column = 0; column + 1 < width; ++column) {
      const int a = index.at(column, row + 1), b = index.at(column + 1, row + 1), c = index.at(column + 1, row),
                d = index.at(column, row);
      if (a >= 0 && c >= 0) {
        add(a, b, c);
        add(a, c, d);
      } else {
        add(a, b, d);
        add(b, c, d);
      }
    }
  }
  return scan;
}

}  // namespace patinate::datasets
