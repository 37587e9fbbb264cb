/// \file
/// Random directions, from additions, multiplications and divisions alone (portable_math.h), so that they do not depend
/// on a C library, an instruction set or a device (tested on x86-64).
#pragma once

#include <cstdint>

#include "libcommon/core/portable_math.h"
#include "simulation/tracing/motion_facts.h"

namespace patinate::simulation {

/// random_direction.inl for C++; devices read the same text.
namespace direction_types {
using namespace motion_types;
using portable_kernel::SineCosine;
#include "simulation/tracing/random_direction.inl"
}  // namespace direction_types

/// Two unit vectors that make a right-handed frame with unit `w`: u x v = w. Continuous but at w = -z [Duff et al.
/// 2017].
struct Frame {
  Vec3 u, v, w;
};
[[nodiscard]] inline Frame frame_around(const Vec3& w) {
  const direction_types::Across across = direction_types::across_of(vector_of(w));
  return {vec3(across.u), vec3(across.v), w};
}

/// Sine and cosine of `turns` / 2^32 of a full turn, absolute error < 1e-11: several times as fast as
/// portable_sine_cosine().
[[nodiscard]] inline SineCosine sine_cosine_of(std::uint32_t turns) {
  return direction_types::sine_cosine_of_turns(turns);
}

/// ((n + 1/2) / 2^32)^power, relative error < 1e-11. @param power  [0, 1].
[[nodiscard]] inline double uniform_power(std::uint32_t n, double power) {
  return direction_types::power_of_uniform(n, power);
}

/// Unit direction at an angle of the given cosine from unit `axis`, turned by `turns` / 2^32 around it.
[[nodiscard]] inline Vec3 direction_around(const Vec3& axis, double cosine, std::uint32_t turns) {
  return vec3(direction_types::direction_at(vector_of(axis), cosine, turns));
}

/// Phong lobe: density (n + 1) / (2 pi) cos^n about unit `axis`, over its half space. @param exponent  n >= 0.
[[nodiscard]] inline Vec3 lobe_direction(const Vec3& axis, double exponent, std::uint32_t a, std::uint32_t b) {
  return vec3(direction_types::direction_in_lobe(vector_of(axis), exponent, a, b));
}

/// Uniform in solid angle within a cone. @param cosine  Of its half angle, [-1, 1]; 1: the axis.
[[nodiscard]] inline Vec3 cone_direction(const Vec3& axis, double cosine, std::uint32_t a, std::uint32_t b) {
  return vec3(direction_types::direction_in_cone(vector_of(axis), cosine, a, b));
}

}  // namespace patinate::simulation
