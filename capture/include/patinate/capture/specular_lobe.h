/// \file
/// The highlight that unlighting fits: a white lobe about the mirror direction.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "patinate/geometry/mesh.h"

namespace patinate::capture {

/// How far from its middle a highlight reaches: Ggx has long tails, Beckmann (nearly Blinn and Phong's) has none.
enum class SpecularLobe { Ggx, Beckmann };

/// A surface shows strength x specular_lobe() x the light that reaches it facing the lamp: F D / 4 of a microfacet
/// surface whose distribution D, of alpha = roughness^2, is GGX [Walter et al. 2007] or Beckmann's [Cook and Torrance
/// 1982], with the "implicit" shadowing term (n.l)(n.v) [Hoffman 2013], times n.l. Strength is the reflectance F0 of a
/// surface that faces camera and lamp: 0.04 for most non-metals.
/// @param normal,to_light,to_camera  Unit. @param roughness  (0, 1].
[[nodiscard]] inline double specular_lobe(SpecularLobe lobe, const Vec3& normal, const Vec3& to_light,
                                          const Vec3& to_camera, double roughness) {
  const double cosine = normal.dot(to_light);
  if (!(cosine > 0.0)) return 0.0;
  const Vec3 middle = to_light + to_camera;
  const double length = middle.norm();
  if (!(length > 1e-12)) return 0.0;
  const double half = std::max(0.0, normal.dot(middle) / length), half2 = half * half,
               alpha2 = roughness * roughness * roughness * roughness;
  if (lobe == SpecularLobe::Beckmann) {
    if (!(half > 1e-3)) return 0.0;
    return cosine * std::exp((half2 - 1.0) / (half2 * alpha2)) / (4.0 * std::numbers::pi * alpha2 * half2 * half2);
  }
  const double spread = half2 * (alpha2 - 1.0) + 1.0;
  return cosine * alpha2 / (4.0 * std::numbers::pi * spread * spread);
}

}  // namespace patinate::capture
