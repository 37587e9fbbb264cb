#include "libcommon/output/light_field.h"

#include <algorithm>
#include <limits>

#include "libcommon/output/orbit_camera.h"
#include "libcommon/output/sampling.h"

namespace patinate {

namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

}  // namespace

LightField::LightField(const RenderOptions& options, const SurfaceOptions& surface, const Surroundings* surroundings)
    : options_(options),
      surroundings_(surroundings),
      turn_(radians(options.azimuth_deg + surface.environment_azimuth_deg)),
      up_(world_from_y_up(Vec3::UnitY(), options.up)),
      disc_radius_(std::tan(radians(options.light_size_deg))) {
  const double azimuth = radians(options.azimuth_deg + options.light_azimuth_deg);
  const double elevation = radians(options.light_elevation_deg);
  light_ = world_from_y_up(
      {std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth)},
      options.up);
  tangents(light_, light_x_, light_y_);
}

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

LightField::Sample LightField::lamp(const Vec2& square) const {
  Sample sample;
  if (surroundings_ != nullptr) {
    const Vec3 direction = surroundings_->sample(square);
    const Vec3 radiance = surroundings_->lamps(direction, sample.pdf);
    sample.direction = world(direction);
    if (sample.pdf > 0.0) sample.weight = radiance / sample.pdf;
    return sample;
  }
  const Vec2 d = disc_radius_ * disc_point(square);
  sample.direction = (light_ + d.x() * light_x_ + d.y() * light_y_).normalized();
  sample.weight = Vec3::Constant(std::numbers::pi * options_.light);
  sample.pdf = std::numeric_limits<double>::infinity();
  if (disc_radius_ > 0.0) (void)lamps(sample.direction, sample.pdf);
  return sample;
}

Vec3 LightField::lamps(const Vec3& direction, double& pdf) const {
  pdf = 0.0;
  if (surroundings_ != nullptr) return Vec3::Zero();
  const double cosine = direction.dot(light_);
  // A point on the rim counts as inside, though rounding may have put it out.
  const double rim = disc_radius_ * (1.0 + 1e-9);
  if (!(cosine > 0.0) || !(disc_radius_ > 0.0) || 1.0 / (cosine * cosine) - 1.0 > rim * rim) return Vec3::Zero();
  pdf = 1.0 / (std::numbers::pi * disc_radius_ * disc_radius_ * cosine * cosine * cosine);
  return Vec3::Constant(std::numbers::pi * options_.light * pdf);
}

}  // namespace patinate
