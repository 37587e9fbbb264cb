// The shape of highlights.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/output/microfacet.h"
#include "patinate/capture/unlight.h"

namespace patinate::capture {

double specular_lobe(const SpecularForm& form, const Vec3& normal, const Vec3& to_light, const Vec3& to_camera,
                     double roughness) {
  constexpr double kLeastCosine = 0.05;  // Of the camera: outlines would else be infinitely bright.
  const double light = normal.dot(to_light), eye = normal.dot(to_camera);
  if (!(light > 0.0)) return 0.0;
  if (form.is_rendered)
    return eye > 0.0 ? Lobe(normal, to_camera, std::max(0.05, roughness)).value(to_light).shape : 0.0;
  double half2 = 0.0;  // Squared cosine of the facet's angle.
  if (form.is_about_mirror) {
    half2 = 0.5 * (1.0 + 2.0 * light * eye - to_light.dot(to_camera));
  } else {
    const double length2 = (to_light + to_camera).squaredNorm(), along = light + eye;
    if (!(length2 > 1e-24) || !(along > 0.0)) return 0.0;
    half2 = along * along / length2;
  }
  if (!(half2 > 1e-6)) return 0.0;
  const double alpha2 = roughness * roughness * roughness * roughness, tangent2 = std::max(0.0, 1.0 / half2 - 1.0);
  const double spread = std::isinf(form.tail) ? std::exp(-tangent2 / alpha2)
                                              : std::pow(1.0 + tangent2 / ((form.tail - 1.0) * alpha2), -form.tail);
  double facing = light;
  if (form.slant == 0.0)
    facing = 1.0 / std::max(kLeastCosine, eye);
  else if (form.slant != 1.0)
    facing = std::pow(light, form.slant) * std::pow(std::max(kLeastCosine, eye), form.slant - 1.0);
  return facing * spread / (4.0 * std::numbers::pi * alpha2 * half2 * half2);
}

}  // namespace patinate::capture
