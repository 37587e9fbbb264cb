/// \file
/// What several parts of the ray caster need to choose directions and to interpolate.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "patinate/geometry/mesh.h"

namespace patinate {

inline constexpr std::uint64_t kRenderSeed = 20;
inline constexpr double kRayOffset = 1e-4;  ///< Share of the diagonal, off the surface.
/// To the lights where a ray of the camera meets the ground, whose even gray shows each that is missing.
inline constexpr int kGroundRays = 16;

[[nodiscard]] inline double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

/// Luminance of a color by Rec.709, linear.
[[nodiscard]] inline double luminance_of(const Vec3& c) { return 0.2126 * c.x() + 0.7152 * c.y() + 0.0722 * c.z(); }

/// Point i of the R2 low-discrepancy sequence [Roberts 2018], shifted; in the unit square.
[[nodiscard]] inline Vec2 sequence_point(int i, const Vec2& shift) {
  constexpr double kA = 0.7548776662466927, kB = 0.5698402909980532;
  const double a = shift.x() + kA * i, b = shift.y() + kB * i;
  return {a - std::floor(a), b - std::floor(b)};
}

/// A shift of such a sequence for each pixel, in the unit square. Shifts of neighbors lie far apart, so that what few
/// rays miss in one pixel its neighbors make up for: a fine dither in place of grain [R4 lattice; Roberts 2018]. Unlike
/// noise it is even over every few pixels.
[[nodiscard]] inline Vec2 pixel_shift(int x, int y) {
  constexpr double kA = 0.8566748838545029, kB = 0.7338918566271260, kC = 0.6287067210378087, kD = 0.5385972572236101;
  const double a = kA * x + kB * y, b = kC * x + kD * y;
  return {a - std::floor(a), b - std::floor(b)};
}

/// The unit square onto the unit disc, areas in proportion.
[[nodiscard]] inline Vec2 disc_point(const Vec2& square) {
  const double r = std::sqrt(square.x()), angle = 2.0 * std::numbers::pi * square.y();
  return {r * std::cos(angle), r * std::sin(angle)};
}

/// Orthonormal tangents of a unit vector [Duff et al. 2017, "Building an orthonormal basis, revisited"].
inline void tangents(const Vec3& n, Vec3& a, Vec3& b) {
  const double sign = std::copysign(1.0, n.z());
  const double p = -1.0 / (sign + n.z()), q = n.x() * n.y() * p;
  a = {1.0 + sign * n.x() * n.x() * p, sign * q, -sign * n.x()};
  b = {q, sign + n.y() * n.y() * p, -n.y()};
}

/// Values at the corners of a triangle at a point of it.
/// @param b1  Weight of corner 1. @param b2  Of corner 2.
template <class T>
[[nodiscard]] T blend(const std::array<T, 3>& corner, double b1, double b2) {
  return (1.0 - b1 - b2) * corner[0] + b1 * corner[1] + b2 * corner[2];
}

}  // namespace patinate
