#include "libcommon/output/surface_material.h"

#include <algorithm>
#include <cmath>

namespace patinate {

namespace {

constexpr double kWaterIndex = 1.33;
constexpr double kWaterF0 = 0.0201;        // ((n - 1) / (n + 1))^2.
constexpr double kWaterDiffuseIn = 0.066;  // Share of diffuse light from outside that water reflects [Lekner and Dorf].
constexpr double kFilmRoughness = 0.12;    // Share of a film on a rough surface.
constexpr double kFilmLevels = 0.7;        // Share of the relief below that a film hides.
constexpr double kFilmBegins = 0.5;        // Wetness up to which water is in pores: darker, but no smoother.

// Share of the surface that lies under a closed film.
double film_of(double wetness) { return std::clamp((wetness - kFilmBegins) / (1.0 - kFilmBegins), 0.0, 1.0); }

Vec3 film_normal(const SeenPoint& p) {
  const double share = kFilmLevels * film_of(p.wetness);
  const Vec3 n = (1.0 - share) * p.normal + share * p.smooth;
  return n.norm() > 1e-6 ? Vec3(n.normalized()) : p.normal;
}

// Reflectance of a dielectric at normal incidence when water is on it in place of air.
double under_water(double f0) {
  const double root = std::sqrt(std::clamp(f0, 0.0, 0.99)), index = (1.0 + root) / (1.0 - root);
  const double ratio = (index - kWaterIndex) / (index + kWaterIndex);
  return ratio * ratio;
}

constexpr double kMinMirror = 0.003;  // Reflectance below which a surface counts as without a mirror, by degrees.

double mean(const Vec3& c) { return c.sum() / 3.0; }

}  // namespace

Vec3 wet_albedo(const Vec3& albedo) {
  // Diffuse light from below is reflected by water as that from above, and beyond the critical angle wholly.
  constexpr double kInside = 1.0 - (1.0 - kWaterDiffuseIn) / (kWaterIndex * kWaterIndex);
  return (1.0 - kInside) * albedo.cwiseMin(1.0).cwiseQuotient(Vec3::Ones() - kInside * albedo.cwiseMin(1.0));
}

SurfaceMaterial::SurfaceMaterial(const SeenPoint& p)
    : base_(p.normal, p.view, p.roughness), coat_(film_normal(p), p.view, kFilmRoughness) {
  const double w = p.wetness, m = p.metalness, closed = film_of(w);
  const LobeEnergy film = lobe_energy(kFilmRoughness, film_normal(p).dot(p.view));
  coat_weight_ = closed * film.compensation(kWaterF0);
  coat_reflected_ = closed * film.reflected(kWaterF0);
  const double through = 1.0 - coat_reflected_;
  const LobeEnergy energy = lobe_energy(p.roughness, p.normal.dot(p.view));
  const Vec3 albedo = ((1.0 - w) * p.color + w * wet_albedo(p.color)).cwiseMin(1.0);
  // So much of each: what is no metal, and metal.
  const auto add = [&](int c, double share, double f0) {
    base_level_[c] += share * energy.compensation(f0) * f0;
    base_grazing_[c] += share * energy.compensation(f0) * (1.0 - f0);
    base_reflected_[c] += share * energy.reflected(f0);
  };
  for (int c = 0; c < 3; ++c) {
    const double f0 = p.specular[c] + closed * (under_water(p.specular[c]) - p.specular[c]);
    // A surface without any mirror has no grazing one either.
    const double has_mirror = std::min(1.0, f0 / kMinMirror);
    add(c, (1.0 - m) * has_mirror * through, f0);
    add(c, m * through, std::min(1.0, p.color[c]));
    diffuse_[c] = (1.0 - m) * through * albedo[c] * (1.0 - has_mirror * energy.reflected(f0));
  }
  base_share_ = mean(base_reflected_);
  coat_share_ = coat_reflected_;
}

SurfaceMaterial::Reflection SurfaceMaterial::reflection(const Vec3& light) const {
  Reflection r;
  const double shares = base_share_ + coat_share_;
  if (!(shares > 0.0)) return r;
  const Lobe::Value base = base_.value(light);
  r.value = base.shape * (base_level_ + fresnel(0.0, base.half_cosine) * base_grazing_);
  r.pdf = base_share_ / shares * base.pdf;
  if (coat_share_ > 0.0) {
    const Lobe::Value coat = coat_.value(light);
    r.value += Vec3::Constant(coat_weight_ * coat.shape * fresnel(kWaterF0, coat.half_cosine));
    r.pdf += coat_share_ / shares * coat.pdf;
  }
  return r;
}

Vec3 SurfaceMaterial::sample(const Vec2& square, double choice) const {
  return choice * (base_share_ + coat_share_) < base_share_ ? base_.sample(square) : coat_.sample(square);
}

}  // namespace patinate
