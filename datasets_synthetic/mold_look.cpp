// Appearance of the mold, and the growth of its patina, at any place and time.
#include <algorithm>
#include <array>
#include <cmath>

#include "datasets_synthetic/mold.h"
#include "libcommon/output/microfacet.h"

namespace patinate::datasets {

namespace {

/// Colors over the progress of the patina.
Vec3 copper_color(double progress) {
  static const std::array<Vec3, 4> kColors{Vec3(0.58, 0.29, 0.18), Vec3(0.30, 0.135, 0.08), Vec3(0.135, 0.095, 0.07),
                                           Vec3(0.20, 0.37, 0.31)};
  constexpr std::array<double, 4> kAt{0.0, 0.35, 0.62, 1.0};
  for (std::size_t i = 1; i < kAt.size(); ++i) {
    if (progress > kAt[i] && i + 1 < kAt.size()) continue;
    const double f = smoother_step(kAt[i - 1], kAt[i], progress);
    return (1.0 - f) * kColors[i - 1] + f * kColors[i];
  }
  return kColors.back();
}

}  // namespace

double Mold::curvature(double x, double y) const {
  const int half = (curvature_.width() - 1) / 2;
  const double u = std::clamp(x / curvature_spacing_ + half, 0.0, static_cast<double>(2 * half) - 1e-9);
  const double v = std::clamp(half - y / curvature_spacing_, 0.0, static_cast<double>(2 * half) - 1e-9);
  const int i = static_cast<int>(u), j = static_cast<int>(v);
  const auto at = [&](int a, int b) { return static_cast<double>(curvature_.at(a, b)); };
  const double f = u - i, g = v - j;
  return (1.0 - g) * ((1.0 - f) * at(i, j) + f * at(i + 1, j)) + g * ((1.0 - f) * at(i, j + 1) + f * at(i + 1, j + 1));
}

double Mold::lacquer(double x, double y) const {
  const double radius = options_.radius_mm, r = std::hypot(x - 0.42 * radius, y + 0.40 * radius) / radius;
  return 1.0 - smoother_step(0.145, 0.165, r);
}

double Mold::mottle(double x, double y) const {
  const double u = x / options_.radius_mm + 1.1, v = y / options_.radius_mm + 1.1;
  return 0.6 * coarse_(u, v) + 0.4 * fine_(u, v);
}

double Mold::progress(double x, double y, double time_d, double curvature) const {
  const double duration = options_.interval_d * std::max(1, options_.num_steps - 1);
  const double reached = std::clamp((curvature - curvature_low_) / (curvature_high_ - curvature_low_), 0.0, 1.0);
  const double begin = 0.70 - 0.85 * std::pow(reached, 1.5) + 0.40 * mottle(x, y);
  return (1.0 - lacquer(x, y)) * smoother_step(begin, begin + 0.85, time_d / duration);
}

double Mold::growth(double x, double y, double time_d) const {
  if (!(options_.relief_mm > 0.0) || !(time_d > 0.0)) return 0.0;
  const double u = x / options_.radius_mm + 1.1, v = y / options_.radius_mm + 1.1;
  return options_.relief_mm * progress(x, y, time_d, smooth_curvature(x, y)) * (1.0 + 1.2 * fine_(v, u));
}

double Mold::smooth_curvature(double x, double y) const {
  const int half = (curvature_.width() - 1) / 2;
  const double last = static_cast<double>(2 * half) - 2.0 - 1e-9;
  const double u = std::clamp(x / curvature_spacing_ + half, 1.0, last),
               v = std::clamp(half - y / curvature_spacing_, 1.0, last);
  const int i = static_cast<int>(u), j = static_cast<int>(v);
  const std::array<double, 4> wx = cubic_weights(u - i), wy = cubic_weights(v - j);
  double sum = 0.0;
  for (int b = 0; b < 4; ++b) {
    double line = 0.0;
    for (int a = 0; a < 4; ++a) line += wx[a] * static_cast<double>(curvature_.at(i - 1 + a, j - 1 + b));
    sum += wy[b] * line;
  }
  return sum;
}

MoldLook Mold::look(double x, double y, double time_d) const {
  const double p = progress(x, y, time_d, curvature(x, y)),
               duration = options_.interval_d * std::max(1, options_.num_steps - 1);
  // Everything that is bare tarnishes a little.
  const double dull = (1.0 - lacquer(x, y)) * (1.0 - std::exp(-2.0 * time_d / duration));
  if (options_.metal) return metal_look(x, y, p, dull);
  MoldLook look;
  look.albedo = copper_color(std::max(p, 0.25 * dull)) * (1.0 + (0.10 + 0.35 * p) * mottle(y, x));
  const double bright = (1.0 - 0.6 * dull) * std::pow(1.0 - p, 2);
  look.specular = options_.highlights * (0.002 + 0.12 * bright);
  look.roughness = 0.37 + 0.18 * (1.0 - bright);
  return look;
}

MoldLook Mold::metal_look(double x, double y, double progress, double dull) const {
  static const Vec3 kCopper(0.93, 0.60, 0.47);  // F0 of bright copper, a little below the pure metal's.
  constexpr double kMineral = 0.04;             // F0 of patina.
  MoldLook look;
  look.metalness = std::pow(1.0 - progress, 2);
  look.albedo =
      (1.0 - look.metalness) * copper_color(std::max(progress, 0.35)) * (1.0 + (0.10 + 0.35 * progress) * mottle(y, x));
  // Tarnish darkens the metal, and dulls it.
  const Vec3 metal = (1.0 - 0.35 * dull) * (1.0 + 0.10 * mottle(y, x)) * kCopper;
  look.reflectance = look.metalness * metal + (1.0 - look.metalness) * kMineral * Vec3::Ones();
  look.specular = look.reflectance.mean();
  look.roughness = 0.50 + 0.08 * dull + 0.20 * (1.0 - look.metalness);
  return look;
}

Vec3 metal_lobe(const MoldLook& look, const Vec3& normal, const Vec3& to_light, const Vec3& to_camera) {
  const double cos_light = normal.dot(to_light), cos_camera = normal.dot(to_camera);
  if (cos_light <= 0.0 || cos_camera <= 0.0) return Vec3::Zero();
  const Lobe::Value value = Lobe(normal, to_camera, look.roughness).value(to_light);
  const LobeEnergy energy = lobe_energy(look.roughness, cos_camera);
  Vec3 lobe;
  for (int c = 0; c < 3; ++c) {
    const double f0 = look.reflectance[c];
    lobe[c] = value.shape * fresnel(f0, value.half_cosine) * energy.compensation(f0) / cos_light;
  }
  return lobe;
}

}  // namespace patinate::datasets
