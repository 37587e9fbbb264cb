/// \file
/// Random directions, from additions, multiplications and divisions alone (portable_math.h), so that they do not depend
/// on a C library or instruction set (tested on x86-64).
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "libcommon/core/portable_math.h"
#include "patinate/geometry/mesh.h"

namespace patinate::simulation {

/// Two unit vectors that make a right-handed frame with unit `w`: u x v = w. Continuous but at w = -z [Duff et al.
/// 2017].
struct Frame {
  Vec3 u, v, w;
};
[[nodiscard]] inline Frame frame_around(const Vec3& w) {
  const double sign = std::copysign(1.0, w.z());
  const double a = -1.0 / (sign + w.z());
  const double b = w.x() * w.y() * a;
  return {{1.0 + sign * w.x() * w.x() * a, sign * b, -sign * w.x()}, {b, sign + w.y() * w.y() * a, -w.y()}, w};
}

/// Sine and cosine of `turns` / 2^32 of a full turn, absolute error < 1e-11: several times as fast as
/// portable_sine_cosine().
[[nodiscard]] inline SineCosine sine_cosine_of(std::uint32_t turns) {
  const std::uint32_t quarter = (turns + (1u << 29)) >> 30;
  const auto rest = static_cast<std::int32_t>(turns - (quarter << 30));
  const double x = rest * (1.5707963267948966 * 0x1.0p-30);  // |x| <= pi / 4
  const double y = x * x;
  const double s =
      x * (1.0 + y * (-1.0 / 6 + y * (1.0 / 120 + y * (-1.0 / 5040 + y * (1.0 / 362880 + y * (-1.0 / 39916800))))));
  const double c =
      1.0 +
      y * (-0.5 + y * (1.0 / 24 + y * (-1.0 / 720 + y * (1.0 / 40320 + y * (-1.0 / 3628800 + y * (1.0 / 479001600))))));
  switch (quarter & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

/// ((n + 1/2) / 2^32)^power, relative error < 1e-11. @param power  [0, 1].
[[nodiscard]] inline double uniform_power(std::uint32_t n, double power) {
  const auto bits = std::bit_cast<std::uint64_t>((n + 0.5) * 0x1.0p-32);
  auto exponent = static_cast<std::int64_t>(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & 0xFFFFFFFFFFFFFull) | (std::uint64_t{1023} << 52));
  if (m > 1.4142135623730951) {
    m *= 0.5;
    ++exponent;
  }
  const double s = (m - 1.0) / (m + 1.0);  // log m = 2 atanh s, |s| < 0.172
  const double s2 = s * s;
  const double log =
      static_cast<double>(exponent) * 0.6931471805599453 +
      s * (2.0 + s2 * (2.0 / 3 + s2 * (2.0 / 5 + s2 * (2.0 / 7 + s2 * (2.0 / 9 + s2 * (2.0 / 11 + s2 * (2.0 / 13)))))));
  const double x = power * log;  // [-23, 0]
  const auto k = static_cast<std::int64_t>(x * 1.4426950408889634 - 0.5);
  const double r = x - static_cast<double>(k) * 0.6931471805599453;  // |r| <= 0.35
  const double e =
      1.0 +
      r * (1.0 + r * (1.0 / 2 +
                      r * (1.0 / 6 +
                           r * (1.0 / 24 +
                                r * (1.0 / 120 +
                                     r * (1.0 / 720 + r * (1.0 / 5040 + r * (1.0 / 40320 + r * (1.0 / 362880)))))))));
  return e * std::bit_cast<double>(static_cast<std::uint64_t>(k + 1023) << 52);
}

/// Unit direction at an angle of the given cosine from unit `axis`, turned by `turns` / 2^32 around it.
[[nodiscard]] inline Vec3 direction_around(const Vec3& axis, double cosine, std::uint32_t turns) {
  const Frame frame = frame_around(axis);
  const SineCosine t = sine_cosine_of(turns);
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  return (sine * t.cosine) * frame.u + (sine * t.sine) * frame.v + cosine * frame.w;
}

/// Phong lobe: density (n + 1) / (2 pi) cos^n about unit `axis`, over its half space. @param exponent  n >= 0.
[[nodiscard]] inline Vec3 lobe_direction(const Vec3& axis, double exponent, std::uint32_t a, std::uint32_t b) {
  return direction_around(axis, uniform_power(a, 1.0 / (exponent + 1.0)), b);
}

/// Uniform in solid angle within a cone. @param cosine  Of its half angle, [-1, 1]; 1: the axis.
[[nodiscard]] inline Vec3 cone_direction(const Vec3& axis, double cosine, std::uint32_t a, std::uint32_t b) {
  return direction_around(axis, 1.0 - (a + 0.5) * 0x1.0p-32 * (1.0 - cosine), b);
}

}  // namespace patinate::simulation
