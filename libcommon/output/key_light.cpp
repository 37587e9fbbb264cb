#include "libcommon/output/key_light.h"

#include <cmath>
#include <numbers>

#include "libcommon/output/orbit_camera.h"
#include "libcommon/output/sampling.h"

namespace patinate {

KeyLight::KeyLight(const RenderOptions& options, const Vec3& middle)
    : middle_(options.target.value_or(middle)),
      distance_(options.light_distance),
      radius_(std::tan(radians(options.light_size_deg))) {
  const double azimuth = radians(options.azimuth_deg + options.light_azimuth_deg);
  const double elevation = radians(options.light_elevation_deg);
  direction_ = world_from_y_up(
      {std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth)},
      options.up);
  tangents(direction_, x_, y_);
}

Vec3 KeyLight::point(const Vec2& square) const {
  const Vec2 d = radius_ * disc_point(square);
  return direction_ + d.x() * x_ + d.y() * y_;
}

double KeyLight::strength_of(const Vec3& from_middle, double distance) const {
  return from_middle.squaredNorm() / (distance * distance);
}

KeyLight::Ray KeyLight::toward(const Vec3& point, const Vec3& place) const {
  if (!is_near()) {
    Ray ray = along(point.normalized(), place);
    if (!(radius_ > 0.0)) ray.density = std::numeric_limits<double>::infinity();
    return ray;
  }
  const Vec3 way = middle_ + distance_ * point - place;
  const double distance = way.norm();
  Ray ray{.direction = way / distance, .strength = strength_of(distance_ * point, distance), .distance = distance};
  // Light of a disc that sends as much in every direction.
  const double side = distance_ * radius_, slant = std::abs(ray.direction.dot(direction_));
  ray.density = radius_ > 0.0 ? distance * distance / (std::numbers::pi * side * side * slant)
                              : std::numeric_limits<double>::infinity();
  return ray;
}

KeyLight::Ray KeyLight::along(const Vec3& direction, const Vec3& place) const {
  Ray ray{.direction = direction};
  const double cosine = direction.dot(direction_);
  // A point on the rim counts as inside, though rounding may have put it out.
  const double rim = radius_ * (1.0 + 1e-9);
  if (!(radius_ > 0.0) || cosine == 0.0) return ray;
  if (!is_near()) {
    if (cosine > 0.0 && 1.0 / (cosine * cosine) - 1.0 <= rim * rim)
      ray.density = 1.0 / (std::numbers::pi * radius_ * radius_ * cosine * cosine * cosine);
    return ray;
  }
  const double distance = (middle_ + distance_ * direction_ - place).dot(direction_) / cosine;
  if (!(distance > 0.0)) return ray;
  const Vec3 point = (place + distance * direction - middle_) / distance_;
  if ((point - direction_).squaredNorm() > rim * rim) return ray;
  return toward(point, place);
}

}  // namespace patinate
