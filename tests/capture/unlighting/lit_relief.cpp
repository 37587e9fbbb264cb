#include "tests/capture/unlighting/lit_relief.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/core/random.h"
#include "patinate/image/color.h"
#include "tests/capture/unlighting/pixel_vectors.h"

namespace patinate::testing_support {

namespace {

struct Bump {
  double x, y, height, width;  ///< Shares of the side (height: of height_mm).
};
constexpr std::array<Bump, 7> kBumps{{{0.0, 0.0, 1.0, 0.09},
                                      {-0.27, 0.22, 0.75, 0.06},
                                      {0.28, 0.25, -0.6, 0.08},
                                      {0.25, -0.27, 0.8, 0.07},
                                      {-0.28, -0.25, 0.45, 0.12},
                                      {0.02, -0.36, 0.35, 0.05},
                                      {-0.05, 0.38, -0.4, 0.06}}};

class Relief {
 public:
  explicit Relief(const LitReliefOptions& o) : o_(o) {}
  /// Height and its derivatives.
  [[nodiscard]] Vec3 at(double x, double y) const {
    Vec3 sum(0, 0, 0);
    for (const Bump& b : kBumps) {
      const double w = b.width * o_.side_mm, dx = x - b.x * o_.side_mm, dy = y - b.y * o_.side_mm;
      const double value = b.height * o_.height_mm * std::exp(-(dx * dx + dy * dy) / (2.0 * w * w));
      sum += Vec3(value, -dx / (w * w) * value, -dy / (w * w) * value);
    }
    return sum;
  }
  [[nodiscard]] Vec3 point(double x, double y) const { return {x, y, at(x, y).x()}; }
  [[nodiscard]] Vec3 normal(double x, double y) const {
    const Vec3 h = at(x, y);
    return Vec3(-h.y(), -h.z(), 1.0).normalized();
  }
  [[nodiscard]] bool is_shadowed(const Vec3& p, const Vec3& to_light) const {
    const double step = 0.004 * o_.side_mm, top = 1.1 * o_.height_mm;
    for (double t = step; p.z() + t * to_light.z() < top && t < 2.0 * o_.side_mm; t += step) {
      const Vec3 q = p + t * to_light;
      if (at(q.x(), q.y()).x() > q.z() + 1e-6) return true;
    }
    return false;
  }

 private:
  const LitReliefOptions& o_;
};

Vec3 albedo_at(double u, double v, bool is_gray) {
  const double wave = 0.5 + 0.5 * std::sin(17.0 * u + 3.0 * std::sin(9.0 * v)),
               check = std::fmod(std::floor(8.0 * u) + std::floor(8.0 * v), 2.0);
  const Vec3 color(0.25 + 0.35 * wave, 0.2 + 0.25 * v + 0.1 * check, 0.35 - 0.15 * wave + 0.15 * u);
  return is_gray ? Vec3(Vec3::Constant(color.mean())) : color;
}

std::vector<Light> ring_of_lamps(const LitReliefOptions& o) {
  std::vector<Light> lights;
  for (int k = 0; k < o.num_lights; ++k) {
    const double around = 2.0 * std::numbers::pi * (k + 0.3) / o.num_lights;
    const double up = (25.0 + 30.0 * ((k * 3) % 4) / 3.0) * std::numbers::pi / 180.0;
    const Vec3 direction(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up));
    Light light;
    light.kind = o.kind;
    light.direction = direction;
    const Vec3 color(1.0, 0.95 + 0.01 * k, 0.9 - 0.01 * k);
    const double distance = o.lamp_distance_mm * (1.0 + 0.05 * (k % 3));
    light.position = distance * direction;
    light.intensity = color * (o.kind == Light::Kind::Near ? distance * distance : 1.0);
    lights.push_back(light);
  }
  return lights;
}

Mesh scanned_relief(const Relief& relief, const LitReliefOptions& o) {
  Mesh mesh;
  const int n = 2 * o.size;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = (i / static_cast<double>(n) - 0.5) * o.side_mm,
                   y = (0.5 - j / static_cast<double>(n)) * o.side_mm;
      RandomStream random(o.seed, mesh.positions.size(), 7);
      mesh.positions.push_back(relief.point(x, y) + Vec3(0, 0, o.scan_noise_mm * random.normal()));
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({a, c, b});
      mesh.triangles.push_back({b, c, d});
    }
  }
  return mesh;
}

/// Turned by a random small angle.
Vec3 disturbed(const Vec3& n, double rms_deg, RandomStream random) {
  const Vec3 t = n.cross(Vec3(0.3, 1, 0.2)).normalized(), b = n.cross(t);
  const double sigma = rms_deg * std::numbers::pi / 180.0 / std::sqrt(2.0);
  return (n + sigma * random.normal() * t + sigma * random.normal() * b).normalized();
}

/// Exposure (into the lamps' intensities), noise, codes.
void photograph(LitRelief& scene, const LitReliefOptions& o) {
  std::vector<float> values;
  for (const ImageF& photo : scene.input.photos)
    values.insert(values.end(), photo.values().begin(), photo.values().end());
  std::erase_if(values, [](float v) { return !(v > 0.0f); });
  const double share = o.saturated > 0.0 ? 1.0 - o.saturated : 1.0;
  const auto white = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), white, values.end());
  const double exposure = (o.saturated > 0.0 ? 1.0 : 0.9) / static_cast<double>(*white);
  for (Light& light : scene.input.lights) light.intensity *= exposure;
  for (std::size_t k = 0; k < scene.input.photos.size(); ++k) {
    ImageF& photo = scene.input.photos[k];
    ImageU8 valid(photo.width(), photo.height(), 1, 255);
    for (int y = 0; y < photo.height(); ++y) {
      for (int x = 0; x < photo.width(); ++x) {
        RandomStream random(
            o.seed, static_cast<std::uint64_t>((static_cast<int>(k) * photo.height() + y) * photo.width() + x), 9);
        for (float& v : photo.pixel(x, y)) {
          const double exposed = exposure * static_cast<double>(v);
          double value = exposed * (1.0 + o.noise_share * random.normal());
          if (o.coding == Coding::Srgb8) {
            const std::uint8_t code = srgb8_from_linear(static_cast<float>(value));
            if (code >= 254) valid.at(x, y) = 0;
            value = static_cast<double>(linear_from_srgb(static_cast<float>(code) / 255.0f));
          } else if (o.saturated > 0.0 && value >= 1.0) {
            valid.at(x, y) = 0;
            value = 1.0;
          }
          v = static_cast<float>(value);
        }
      }
    }
    scene.input.valid.push_back(valid);
  }
}

}  // namespace

LitRelief lit_relief(const LitReliefOptions& o) {
  const Relief relief(o);
  LitRelief scene;
  const int n = o.size, channels = o.is_gray ? 1 : 3;
  scene.input.lights = ring_of_lamps(o);
  scene.input.camera_center = Vec3(0, 0, 6.0 * o.side_mm);
  scene.input.photos.assign(scene.input.lights.size(), ImageF(n, n, channels));
  scene.input.position_mm = scene.input.normal = scene.normal = ImageF(n, n, 3);
  scene.albedo = ImageF(n, n, channels);
  scene.shadow = ImageU8(n, n, o.num_lights);
  scene.scan = scanned_relief(relief, o);
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const double u = (x + 0.5) / n, v = (y + 0.5) / n;
      const Vec3 p = relief.point((u - 0.5) * o.side_mm * 0.98, (0.5 - v) * o.side_mm * 0.98),
                 to_eye = (*scene.input.camera_center - p).normalized();
      const Vec3 normal = relief.normal(p.x(), p.y()), albedo = albedo_at(u, v, o.is_gray);
      const double gloss = o.gloss * (o.gloss_varies ? u : 1.0);
      put(scene.input.position_mm, x, y, p);
      put(scene.normal, x, y, normal);
      put(scene.albedo, x, y, albedo);
      put(scene.input.normal, x, y,
          disturbed(normal, o.normal_noise_deg, RandomStream(o.seed, static_cast<std::uint64_t>(y * n + x), 5)));
      for (int k = 0; k < o.num_lights; ++k) {
        const Light& light = scene.input.lights[k];
        const Vec3 l = direction_to(light, p);
        const double cosine = normal.dot(l);
        Vec3 value = albedo.cwiseProduct(o.ambient) / std::numbers::pi;
        const bool is_shadowed = o.cast_shadows && cosine > 0.0 && relief.is_shadowed(p, l);
        if (is_shadowed) scene.shadow.at(x, y, k) = 255;
        if (cosine > 0.0 && !is_shadowed) {
          const double half = std::max(0.0, normal.dot((l + to_eye).normalized()));
          const double a2 = std::pow(o.roughness, 4.0), spread = half * half * (a2 - 1.0) + 1.0;
          const double lobe = gloss * (o.lobe == Gloss::Ggx ? a2 / (4.0 * std::numbers::pi * spread * spread)
                                                            : (o.gloss_exponent + 8.0) / (8.0 * std::numbers::pi) *
                                                                  std::pow(half, o.gloss_exponent));
          value += cosine * light_at(light, p).cwiseProduct(albedo / std::numbers::pi + Vec3::Constant(lobe));
        }
        put(scene.input.photos[k], x, y, value);
      }
    }
  }
  if (o.coding != Coding::Float || o.saturated > 0.0 || o.noise_share > 0.0) photograph(scene, o);
  return scene;
}

double relative_error_percent(const capture::UnlightResult& result, const ImageF& truth) {
  double sum = 0.0, count = 0.0;
  for (int y = 0; y < truth.height(); ++y) {
    for (int x = 0; x < truth.width(); ++x) {
      if (result.mask.at(x, y) == 0) continue;
      for (int c = 0; c < truth.channels(); ++c) {
        const auto is = static_cast<double>(result.albedo.at(x, y, c)), should = static_cast<double>(truth.at(x, y, c));
        sum += (is - should) * (is - should) / (should * should);
        count += 1.0;
      }
    }
  }
  return 100.0 * std::sqrt(sum / std::max(1.0, count));
}

double median_angle_deg(const ImageF& a, const ImageF& b, const ImageU8& mask) {
  std::vector<double> angles;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      const Vec3 p = Eigen::Vector3f(a.at(x, y, 0), a.at(x, y, 1), a.at(x, y, 2)).cast<double>(),
                 q = Eigen::Vector3f(b.at(x, y, 0), b.at(x, y, 1), b.at(x, y, 2)).cast<double>();
      angles.push_back(std::atan2(p.cross(q).norm(), p.dot(q)) * 180.0 / std::numbers::pi);
    }
  }
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle;
}

}  // namespace patinate::testing_support
