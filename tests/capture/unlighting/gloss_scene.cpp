#include "tests/capture/unlighting/gloss_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "capture/relit/relit_view.h"
#include "libcommon/core/random.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/image/color.h"
#include "tests/capture/unlighting/pixel_vectors.h"

namespace patinate::testing_support {

namespace {

constexpr double kPieceRadius = 60.0;  ///< mm.
enum Purpose : std::uint32_t { kLamps = 11, kScan, kPose, kPhotos, kShape, kColor };

/// Height over a disc, mm.
double height_of(Piece piece, double x, double y) {
  const double u = x / kPieceRadius, v = y / kPieceRadius;
  if (piece == Piece::Saddle) {
    return kPieceRadius * (0.22 * (u * u - 0.8 * v * v) + 0.018 * std::sin(11.0 * u + 4.0 * v) +
                           0.05 * std::exp(-18.0 * ((u - 0.3) * (u - 0.3) + (v + 0.25) * (v + 0.25))));
  }
  const double r = std::hypot(u, v), around = std::atan2(v, u);
  const double flutes = 0.02 * std::cos(9.0 * around) * std::exp(-30.0 * (r - 0.6) * (r - 0.6));
  double dents = 0.0;
  for (int i = 0; i < 6; ++i) {
    RandomStream random(5, static_cast<std::uint64_t>(i), kShape);
    const double a = random.uniform() * 1.2 - 0.6, b = random.uniform() * 1.2 - 0.6;
    dents -= 0.013 * std::exp(-((u - a) * (u - a) + (v - b) * (v - b)) / (0.09 * 0.09));
  }
  return kPieceRadius * (0.24 * std::exp(-2.2 * r * r) + flutes + dents);
}

Vec3 normal_of(Piece piece, double x, double y) {
  constexpr double kStep = 1e-3;
  return Vec3(height_of(piece, x - kStep, y) - height_of(piece, x + kStep, y),
              height_of(piece, x, y - kStep) - height_of(piece, x, y + kStep), 2.0 * kStep)
      .normalized();
}

Vec3 albedo_of(double x, double y) {
  const double u = x / kPieceRadius, v = y / kPieceRadius;
  const double mottle = 0.12 * std::sin(5.0 * u + 2.0 * std::sin(4.0 * v)) * std::cos(6.0 * v - 1.0) +
                        0.06 * std::sin(17.0 * u - 9.0 * v);
  return Vec3(0.58, 0.29, 0.18) * (1.0 + mottle);
}

double lobe_of(const GlossSceneOptions& o, const Vec3& n, const Vec3& l, const Vec3& v, double f0) {
  const double nl = n.dot(l), nv = n.dot(v);
  if (!(nl > 0.0) || !(nv > 0.0)) return 0.0;
  const Vec3 h = (l + v).normalized();
  const double nh = n.dot(h), vh = v.dot(h), a2 = o.width * o.width, tan2 = 1.0 / (nh * nh) - 1.0;
  const double fresnel = o.has_fresnel ? f0 + (1.0 - f0) * std::pow(1.0 - vh, 5.0) : f0;
  const double exponent = 2.0 / a2 - 2.0;
  switch (o.lobe) {
    case LobeModel::None:
      return 0.0;
    case LobeModel::Blinn:
      return fresnel * (exponent + 8.0) / (8.0 * std::numbers::pi) * std::pow(nh, exponent) * nl;
    case LobeModel::Phong: {
      const double rv = std::max(0.0, (2.0 * nl * n - l).dot(v)), n4 = exponent / 4.0;
      return fresnel * (n4 + 2.0) / (2.0 * std::numbers::pi) * std::pow(rv, n4) * nl;
    }
    case LobeModel::Ward:
      return fresnel * std::exp(-tan2 / a2) / (4.0 * std::numbers::pi * a2 * std::sqrt(nl * nv)) * nl;
    case LobeModel::CookTorrance: {
      const double d = std::exp(-tan2 / a2) / (std::numbers::pi * a2 * nh * nh * nh * nh);
      return fresnel * d * std::min({1.0, 2.0 * nh * nv / vh, 2.0 * nh * nl / vh}) / (4.0 * nv);
    }
    case LobeModel::Ggx: {
      const double spread = nh * nh * (a2 - 1.0) + 1.0, d = a2 / (std::numbers::pi * spread * spread);
      const auto smith = [a2](double c) { return 2.0 * c / (c + std::sqrt(a2 + (1.0 - a2) * c * c)); };
      return fresnel * d * smith(nl) * smith(nv) / (4.0 * nv);
    }
  }
  return 0.0;
}

std::vector<Light> lamps(const GlossSceneOptions& o) {
  std::vector<Light> lights;
  for (int k = 0; k < o.num_lights; ++k) {
    RandomStream random(o.seed, static_cast<std::uint64_t>(k), kLamps);
    const double around = 2.0 * std::numbers::pi * (k + 0.2 + 0.15 * random.uniform()) / o.num_lights,
                 up = (k % 2 == 0 ? 0.98 : 0.7) + 0.1 * random.uniform(),
                 distance = kPieceRadius * (5.0 + 1.5 * random.uniform());
    Light light;
    light.position = distance * Vec3(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up));
    light.intensity = 1.2 * std::numbers::pi * distance * distance * Vec3(1.0, 0.97, 0.92);
    lights.push_back(light);
  }
  return lights;
}

Camera camera_of(int size) {
  const Vec3 eye(0.0, -1.6 * kPieceRadius, 6.4 * kPieceRadius);
  const Vec3 forward = -eye.normalized(), right = Vec3::UnitX(), down = forward.cross(right);
  CameraParameters p;
  p.width = p.height = size;
  p.rotation.row(0) = right, p.rotation.row(1) = down, p.rotation.row(2) = forward;
  p.translation = -(p.rotation * eye);
  p.fx = p.fy = size / 2.2 * eye.norm() / kPieceRadius;
  p.cx = p.cy = 0.5 * (size - 1);
  return Camera(p);
}

Mesh scanned_piece(const GlossSceneOptions& o) {
  Mesh mesh;
  const int half = static_cast<int>(kPieceRadius / o.scan_spacing_mm), n = 2 * half + 1;
  std::vector<int> index(static_cast<std::size_t>(n * n), -1);
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const double x = (i - half) * o.scan_spacing_mm, y = (j - half) * o.scan_spacing_mm;
      if (std::hypot(x, y) > kPieceRadius) continue;
      RandomStream random(o.seed, static_cast<std::uint64_t>(j * n + i), kScan);
      index[j * n + i] = static_cast<int>(mesh.positions.size());
      mesh.positions.emplace_back(x, y, height_of(o.piece, x, y) + o.scan_noise_mm * random.normal());
    }
  }
  for (int j = 0; j + 1 < n; ++j) {
    for (int i = 0; i + 1 < n; ++i) {
      const auto at = [&](int di, int dj) { return index[(j + dj) * n + i + di]; };
      const int a = at(0, 0), b = at(1, 0), c = at(1, 1), d = at(0, 1);
      if (a < 0 || b < 0 || c < 0 || d < 0) continue;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

RigidTransform pose_error(const GlossSceneOptions& o) {
  RandomStream random(o.seed, 0, kPose);
  const auto some = [&] { return Vec3(random.normal(), random.normal(), random.normal()); };
  RigidTransform pose;
  pose.rotation = rotation_of(o.pose_deg * std::numbers::pi / 180.0 / std::sqrt(3.0) * some());
  pose.translation = o.pose_mm / std::sqrt(3.0) * some();
  return pose;
}

/// Where the ray of a place in the photograph meets the piece itself.
std::optional<Vec3> on_piece(Piece piece, const Camera& camera, const Vec2& pixel) {
  const std::optional<CameraRay> ray = camera.ray(pixel);
  if (!ray) return std::nullopt;
  const Vec3& d = ray->direction;
  double t = -camera.center().z() / d.z();
  for (int i = 0; i < 30; ++i) {
    const Vec3 p = camera.center() + t * d, n = normal_of(piece, p.x(), p.y());
    t -= (p.z() - height_of(piece, p.x(), p.y())) * n.z() / d.dot(n);
  }
  const Vec3 p = camera.center() + t * d;
  if (!(std::hypot(p.x(), p.y()) < 0.99 * kPieceRadius) || !(std::abs(p.z() - height_of(piece, p.x(), p.y())) < 1e-6))
    return std::nullopt;
  return p;
}

bool is_shadowed(Piece piece, const Vec3& p, const Vec3& to_light) {
  const double step = 0.01 * kPieceRadius;
  for (double t = step; t < kPieceRadius; t += step) {
    const Vec3 q = p + t * to_light;
    if (std::hypot(q.x(), q.y()) > kPieceRadius) return false;
    if (height_of(piece, q.x(), q.y()) > q.z() + 1e-6) return true;
  }
  return false;
}

Vec3 value_of(const GlossSceneOptions& o, const Light& light, const Vec3& eye, const Vec3& p) {
  const Vec3 n = normal_of(o.piece, p.x(), p.y()), l = direction_to(light, p), v = (eye - p).normalized();
  if (!(n.dot(l) > 0.0) || is_shadowed(o.piece, p, l)) return Vec3::Zero();
  const Vec3 albedo = albedo_of(p.x(), p.y());
  const Vec3 tint = o.material == Material::Metal ? Vec3(albedo / albedo.mean()) : Vec3(1, 1, 1);
  Vec3 reflected = albedo / std::numbers::pi * n.dot(l);
  for (int c = 0; c < 3; ++c) reflected[c] += lobe_of(o, n, l, v, o.strength * tint[c]);
  return light_at(light, p).cwiseProduct(reflected);
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

GlossScene gloss_scene(const GlossSceneOptions& o) {
  const Camera camera = camera_of(o.size);
  Mesh mesh = scanned_piece(o);
  const RigidTransform beside = pose_error(o);
  for (Vec3& p : mesh.positions) p = beside.apply(p);
  GlossScene scene{.scan = std::make_unique<const Mesh>(capture::with_scan_normals(std::move(mesh))),
                   .input = {},
                   .albedo = ImageF(o.size, o.size, 3),
                   .normal = ImageF(o.size, o.size, 3)};
  const capture::ScanView view = capture::view_scan(*scene.scan, RayScene(*scene.scan), camera);
  capture::UnlightInput& in = scene.input;
  in.lights = lamps(o);
  in.position_mm = view.position_mm;
  in.normal = view.normal;
  in.mask = view.seen;
  in.blockers = scene.scan.get();
  in.camera_center = camera.center();
  in.photos.assign(in.lights.size(), ImageF(o.size, o.size, 3));
  in.valid.assign(in.lights.size(), ImageU8(o.size, o.size, 1, 255));
  const RigidTransform back = beside.inverse();
  for (int y = 0; y < o.size; ++y) {
    for (int x = 0; x < o.size; ++x) {
      if (in.mask.at(x, y) == 0) continue;
      // The texel stands for the place of the piece that was scanned there; its photographs show what lies at the pixel
      // where the pose puts it.
      const std::optional<Vec3> p = on_piece(o.piece, camera, Vec2(x, y));
      const std::optional<Vec2> meant = camera.project(back.apply(vector_at(view.position_mm, x, y)));
      const std::optional<Vec3> place = meant ? on_piece(o.piece, camera, *meant) : std::nullopt;
      if (!p || !place) {
        in.mask.at(x, y) = 0;
        continue;
      }
      put(scene.albedo, x, y, albedo_of(place->x(), place->y()));
      put(scene.normal, x, y, normal_of(o.piece, p->x(), p->y()));
      for (std::size_t k = 0; k < in.lights.size(); ++k) {
        const Vec3 value = value_of(o, in.lights[k], camera.center(), *p);
        RandomStream random(
            o.seed,
            (k * static_cast<std::size_t>(o.size) + static_cast<std::size_t>(y)) * static_cast<std::size_t>(o.size) +
                static_cast<std::size_t>(x),
            kPhotos);
        for (int c = 0; c < 3; ++c) {
          const float code =
              srgb_from_linear(static_cast<float>(value[c])) + static_cast<float>(o.noise * random.normal());
          const float rounded = std::round(255.0f * std::clamp(code, 0.0f, 1.0f)) / 255.0f;
          if (rounded > 253.5f / 255.0f) in.valid[k].at(x, y) = 0;
          in.photos[k].at(x, y, c) = linear_from_srgb(rounded);
        }
      }
    }
  }
  return scene;
}

AlbedoErrors albedo_errors(const GlossScene& scene, const capture::UnlightResult& result) {
  AlbedoErrors errors;
  std::vector<double> off;
  double squares = 0.0, count = 0.0;
  for (int y = 0; y < scene.albedo.height(); ++y) {
    for (int x = 0; x < scene.albedo.width(); ++x) {
      if (result.mask.at(x, y) == 0) continue;
      count += 1.0;
      for (int c = 0; c < 3; ++c) {
        const auto truth = static_cast<double>(scene.albedo.at(x, y, c)),
                   error = static_cast<double>(result.albedo.at(x, y, c)) - truth;
        errors.bias[c] += 100.0 * error / truth;
        squares += error * error / (truth * truth);
        off.push_back(std::abs(error) / static_cast<double>(result.stddev.at(x, y, c)));
      }
    }
  }
  errors.bias /= std::max(1.0, count);
  errors.rms = 100.0 * std::sqrt(squares / std::max(1.0, 3.0 * count));
  errors.z = 1.4826 * median_of(std::move(off));
  errors.determined = count / static_cast<double>(std::max<std::int64_t>(1, result.num_surface));
  return errors;
}

}  // namespace patinate::testing_support
