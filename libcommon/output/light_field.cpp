#include "libcommon/output/light_field.h"

#include <algorithm>
#include <numbers>

#include "libcommon/output/orbit_camera.h"
#include "libcommon/output/sampling.h"

namespace patinate {

LightField::LightField(const RenderOptions& options, const SurfaceOptions& surface, const Surroundings* surroundings,
                       const Vec3& middle)
    : options_(options),
      surroundings_(surroundings),
      turn_((options.azimuth_deg + surface.environment_azimuth_deg) * std::numbers::pi / 180.0),
      up_(world_from_y_up(Vec3::UnitY(), options.up)),
      key_(options, middle) {}

Vec3 LightField::local(const Vec3& world) const {
  const Vec3 d = options_.up == UpAxis::Y ? world : Vec3(world.x(), world.z(), -world.y());
  const double c = std::cos(turn_), s = std::sin(turn_);
  return {c * d.x() - s * d.z(), d.y(), s * d.x() + c * d.z()};
}

Vec3 LightField::world(const Vec3& local) const {
  const double c = std::cos(turn_), s = std::sin(turn_);
  return world_from_y_up({c * local.x() + s * local.z(), local.y(), c * local.z() - s * local.x()}, options_.up);
}

Vec3 LightField::around(const Vec3& direction, double solid_angle) const {
  if (surroundings_ != nullptr) return surroundings_->radiance(local(direction), solid_angle);
  // Radiance a + b cos whose irradiance is that of smooth_on(): cosines keep 2/3 of their size.
  const double g = options_.ambient_gradient;
  return Vec3::Constant(options_.ambient * std::max(0.0, 1.0 - 0.5 * g + 0.75 * g * direction.dot(up_)));
}

Vec3 LightField::smooth_on(const Vec3& normal) const {
  if (surroundings_ != nullptr) return surroundings_->smooth_on(local(normal));
  return Vec3::Constant(options_.ambient * (1.0 - options_.ambient_gradient * 0.5 * (1.0 - normal.dot(up_))));
}

bool LightField::has_lamps() const {
  return surroundings_ != nullptr ? surroundings_->has_lamps() : options_.light > 0.0;
}

LightField::Lamp LightField::lamp(const Vec2& square) const {
  if (surroundings_ == nullptr) return {.of_surroundings = {}, .point = key_.point(square)};
  Sample sample;
  const Vec3 direction = surroundings_->sample(square);
  const Vec3 radiance = surroundings_->lamps(direction, sample.pdf);
  sample.direction = world(direction);
  if (sample.pdf > 0.0) sample.weight = radiance / sample.pdf;
  return {.of_surroundings = sample};
}

LightField::Sample LightField::seen(const Lamp& lamp, const Vec3& place) const {
  if (surroundings_ != nullptr) return lamp.of_surroundings;
  const KeyLight::Ray ray = key_.toward(lamp.point, place);
  return {.direction = ray.direction,
          .weight = Vec3::Constant(std::numbers::pi * options_.light * ray.strength),
          .pdf = ray.density,
          .distance = ray.distance};
}

LightField::Sample LightField::lamp_along(const Vec3& direction, const Vec3& place) const {
  Sample sample{.direction = direction};
  if (surroundings_ != nullptr) return sample;
  const KeyLight::Ray ray = key_.along(direction, place);
  sample.pdf = ray.density;
  sample.distance = ray.distance;
  if (ray.density > 0.0) sample.weight = Vec3::Constant(std::numbers::pi * options_.light * ray.strength * ray.density);
  return sample;
}

}  // namespace patinate
