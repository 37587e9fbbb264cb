// The shape of highlights.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/output/microfacet.h"
#include "patinate/capture/unlight.h"

namespace patinate::capture {

namespace {
constexpr double kMinRoughness = 0.05;  ///< Least roughness of the lobe that is rendered.
}

double specular_lobe(const SpecularForm& form, const Vec3& normal, const Vec3& to_light, const Vec3& to_camera,
                     double roughness) {
  constexpr double kMinCosine = 0.05;  // Least cosine to the camera: outlines would else be infinitely bright.
  const double light = normal.dot(to_light), eye = normal.dot(to_camera);
  if (!(light > 0.0)) return 0.0;
  if (form.is_rendered) return lobe_turn(normal, to_camera, to_light, std::max(kMinRoughness, roughness)).shape;
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
    facing = 1.0 / std::max(kMinCosine, eye);
  else if (form.slant != 1.0)
    facing = std::pow(light, form.slant) * std::pow(std::max(kMinCosine, eye), form.slant - 1.0);
  return facing * spread / (4.0 * std::numbers::pi * alpha2 * half2 * half2);
}

SpecularTurn specular_turn(const SpecularForm& form, const Vec3& normal, const std::array<Vec3, 2>& across,
                           const Vec3& to_light, const Vec3& to_camera, double roughness) {
  if (!form.is_rendered) return specular_turn_by_differences(form, normal, across, to_light, to_camera, roughness);
  const LobeTurn turn = lobe_turn(normal, to_camera, to_light, std::max(kMinRoughness, roughness));
  return {turn.shape, {turn.by_normal.dot(across[0]), turn.by_normal.dot(across[1])}};
}

SpecularTurn specular_turn_by_differences(const SpecularForm& form, const Vec3& normal,
                                          const std::array<Vec3, 2>& across, const Vec3& to_light,
                                          const Vec3& to_camera, double roughness) {
  constexpr double kTurn = 1e-4;  // Step of numeric derivatives, rad.
  SpecularTurn out{.value = specular_lobe(form, normal, to_light, to_camera, roughness)};
  for (std::size_t i = 0; i < across.size(); ++i) {
    const Vec3 turned = (normal + kTurn * across[i]).normalized();
    out.slope[i] = (specular_lobe(form, turned, to_light, to_camera, roughness) - out.value) / kTurn;
  }
  return out;
}

}  // namespace patinate::capture
