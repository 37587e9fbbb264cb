#include "patinate/controls/exposure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/controls/light_set.h"

namespace patinate {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kSunRays = 64;
constexpr double kAnyDistance = 1e30;

/// Point i of n, evenly over the unit disc [Vogel 1979].
Vec2 disc_point(int i, int n) {
  constexpr double kGoldenAngle = std::numbers::pi * (3.0 - 2.23606797749978969641);
  const double r = std::sqrt((i + 0.5) / n);
  return {r * std::cos(kGoldenAngle * i), r * std::sin(kGoldenAngle * i)};
}

LightSet sun_lights(const std::array<double, 3>& up_numbers, const SunOptions& o) {
  const Vec3 up = unit_direction(up_numbers, "up"), noon = unit_direction(o.direction, "sun_direction");
  Vec3 east = up.cross(noon);
  if (!(east.norm() > 1e-9)) east = up.unitOrthogonal();
  east.normalize();
  const bool is_moving = o.arc_deg > 0.0;
  const int num = is_moving || o.radius_deg > 0.0 ? kSunRays : 1;
  LightSet lights;
  for (int i = 0; i < num; ++i) {
    const double hour = is_moving ? o.arc_deg * kDegree * ((i + 0.5) / num - 0.5) : 0.0;
    const Vec3 center = std::cos(hour) * noon + std::sin(hour) * east;
    const Vec3 right = center.unitOrthogonal(), above = center.cross(right);
    const Vec2 p = std::tan(o.radius_deg * kDegree) * (num > 1 ? disc_point(i, num) : Vec2(0.0, 0.0));
    lights.directions.push_back((center + p.x() * right + p.y() * above).normalized());
    lights.weights.push_back(1.0 / num);
  }
  return lights;
}

}  // namespace

void describe(OptionVisitor& v, SunOptions& o) {
  v.visit({"sun_direction", "from the surface to the sun of `sun` and `exposure`, at noon", "", {}},
          std::span<double>(o.direction));
  v.visit({"sun_radius", "half angle of the sun's disc; 0 gives hard shadows", "deg", between(0, 45)}, o.radius_deg);
  v.visit({"sun_arc", "the sun's path over the sky, centered on noon; 180 is a day, 0 is a fixed sun", "deg",
           between(0, 180)},
          o.arc_deg);
}

void describe(OptionVisitor& v, ExposureOptions& o) {
  v.visit({"sky_rays", "number of rays toward the sky for `exposure`", "", between(16, 4096)}, o.num_rays);
  v.visit({"sun_share", "share of the light in `exposure` that comes from the sun; the rest comes from the sky", "",
           between(0, 1)},
          o.sun_share);
}

ControlMap exposure_map(const TexelMap& map, const std::array<double, 3>& up_numbers, const ExposureOptions& options,
                        const SunOptions& sun, const ImageF& panorama, const RunControl& control) {
  check_ranges(options);
  check_ranges(sun);
  const Vec3 up = unit_direction(up_numbers, "up");
  LightSet lights = panorama.empty() ? even_sky(up, options.num_rays) : panorama_sky(up, options.num_rays, panorama);
  for (double& w : lights.weights) w *= 1.0 - options.sun_share;
  if (options.sun_share > 0.0) {
    const LightSet disc = sun_lights(up_numbers, sun);
    for (std::size_t i = 0; i < disc.directions.size(); ++i) {
      lights.directions.push_back(disc.directions[i]);
      lights.weights.push_back(options.sun_share * disc.weights[i]);
    }
  }
  const SmoothSurface surface = surface_for_rays(map, control.part(0.0, 0.1));
  const ImageF values = shadowed_light(surface, lights, kAnyDistance, false, control.part(0.1, 0.99));
  double high = 1.0;
  if (!panorama.empty()) {
    for (const float v : values.values()) high = std::max(high, static_cast<double>(v));
  }
  ControlMap out = normalized_control(values, map, {0.0, high}, "share");
  control.report(1.0);
  return out;
}

ControlMap sun_map(const TexelMap& map, const std::array<double, 3>& up, const SunOptions& options,
                   const RunControl& control) {
  check_ranges(options);
  const LightSet lights = sun_lights(up, options);
  const SmoothSurface surface = surface_for_rays(map, control.part(0.0, 0.3));
  const ImageF values = shadowed_light(surface, lights, kAnyDistance, false, control.part(0.3, 0.99));
  ControlMap out = normalized_control(values, map, {0.0, 1.0}, "cosine");
  control.report(1.0);
  return out;
}

}  // namespace patinate
