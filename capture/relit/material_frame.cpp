#include "capture/relit/material_frame.h"

#include <algorithm>

#include "capture/unlighting/unlight_work.h"

namespace patinate::capture {

namespace {

constexpr double kMineral = 0.04;   ///< F0 of what is no metal beside metal.
constexpr double kMinMetal = 0.02;  ///< Less is none.
constexpr double kPure = 0.95;      ///< Metalness beyond which no diffuse light tells the color.

struct PixelFrame {
  Vec3 color, tint;
  double strength = 0.0;
};

PixelFrame pixel_frame(const Vec3& albedo, const Vec3& f0, double metalness) {
  const double m = metalness;
  if (!(m > kMinMetal)) return {albedo, Vec3::Zero(), std::clamp(f0.mean(), 0.0, 1.0)};
  const Vec3 tint = ((f0 - (1.0 - m) * Vec3::Constant(kMineral)) / m).cwiseMax(kMineral).cwiseMin(1.0);
  if (m > kPure) return {tint, tint, kMineral};
  const Vec3 of_diffuse = albedo / (1.0 - m), base = of_diffuse + m * m * (tint - of_diffuse);
  const double rest = (f0.mean() - m * base.mean()) / ((1.0 - m) * tint.mean());
  return {((base - m * tint) / (1.0 - m)).cwiseMax(0.0).cwiseMin(1.0), tint, std::clamp(rest, 0.0, 1.0)};
}

}  // namespace

MaterialFrame material_frame(const UnlightResult& result) {
  const ImageF& albedo = result.albedo;
  MaterialFrame out{ImageF(albedo.width(), albedo.height(), 3), result.specular,
                    ImageF(albedo.width(), albedo.height(), 3)};
  for (int y = 0; y < out.color.height(); ++y) {
    for (int x = 0; x < out.color.width(); ++x) {
      if (result.mask.at(x, y) == 0) continue;
      const PixelFrame pixel = pixel_frame(vector_of(result.albedo, x, y), vector_of(result.reflectance, x, y),
                                           static_cast<double>(result.metalness.at(x, y)));
      for (int c = 0; c < 3; ++c) {
        out.color.at(x, y, c) = static_cast<float>(pixel.color[c]);
        out.tint.at(x, y, c) = static_cast<float>(pixel.tint[c]);
      }
      out.specular.at(x, y, 0) = static_cast<float>(pixel.strength);
    }
  }
  return out;
}

}  // namespace patinate::capture
