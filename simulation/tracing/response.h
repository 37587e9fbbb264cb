/// \file
/// What a gammaton does where it has hit: Russian roulette between bouncing, floating and being absorbed.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>

#include "simulation/tracing/pieces.h"
#include "simulation/tracing/random_direction.h"
#include "simulation/tracing/wet_paths.h"

namespace patinate::simulation {

enum class Outcome { Alive, Absorbed, Rested };

namespace response_detail {

inline constexpr std::uint32_t kMostTries = 8;

/// Nearly level ground below it (1), or above it, on which it hangs (-1).
inline int levelness(const MotionScene& scene, const Vec3& normal) {
  const double gravity = std::sqrt(scene.gravity.squaredNorm());
  if (gravity == 0.0) return 1;
  const double up = -normal.dot(scene.gravity) / gravity;
  const double level = scene.rest_cosine;
  return up >= level ? 1 : (up <= -level ? -1 : 0);
}

}  // namespace response_detail

/// Bounce: the velocity is reflected about `normal`, turned within a Phong lobe, again and again until it leaves the
/// triangle (after kMostTries mirrored up), and slowed down. Float: the same about the triangle's own normal, projected
/// into its plane: a smoothed normal would lead drops astray on a flat wall; on ground that hangs, within rest_slope of
/// level, it drips off as soon as it does not run downhill. Whatever is slower than rest_speed on nearly level ground
/// rests.
/// @param gammaton      In contact; Flying or Floating after it.
/// @param front_normal  For bounces to reflect about, unit, for the triangle's front.
/// @param words         words(k): four random words, other ones for each k.
/// @param wet           What turns those that float; may be null.
template <class Words>
[[nodiscard]] Outcome respond_to_contact(const MotionScene& scene, const Behavior& behavior, Gammaton& g,
                                         const Vec3& front_normal, Words&& words, const WetPaths* wet = nullptr) {
  using response_detail::kMostTries;
  const double side = g.is_front ? 1.0 : -1.0;
  const Vec3 ground = side * scene.frames.normal(g.at.triangle);
  const std::array<std::uint32_t, 4> first = words(0);
  const double roulette = (first[0] + 0.5) * 0x1.0p-32;
  if (roulette >= behavior.bounce + behavior.floating) return Outcome::Absorbed;
  const bool is_bounce = roulette < behavior.bounce;

  const double speed = std::sqrt(g.velocity.squaredNorm());
  Vec3 heading = speed > 0.0 ? Vec3(g.velocity / speed) : ground;
  Vec3 normal = is_bounce ? Vec3(side * front_normal) : ground;
  if (heading.dot(normal) >= 0.0) normal = ground;  // seen from behind the shading normal
  if (const double into = heading.dot(normal); into < 0.0) heading -= 2.0 * into * normal;
  if (is_bounce) {
    Vec3 chosen = lobe_direction(heading, scene.options.lobe_exponent_bounce, first[1], first[2]);
    for (std::uint32_t k = 1; k < kMostTries && !(chosen.dot(ground) > 0.0); ++k) {
      const std::array<std::uint32_t, 4> w = words(k);
      chosen = lobe_direction(heading, scene.options.lobe_exponent_bounce, w[1], w[2]);
    }
    const double up = chosen.dot(ground);
    if (!(up > 0.0)) chosen -= 2.0 * up * ground;
    g.velocity = speed * (1.0 - behavior.deceleration_bounce) * chosen;
    g.state = GammatonState::Flying;
    g.position = scene.frames.point(g.at) + scene.skin * ground;
  } else {
    const Vec3 chosen =
        speed > 0.0 ? lobe_direction(heading, scene.options.lobe_exponent_float, first[1], first[2]) : ground;
    Vec3 along = chosen - chosen.dot(ground) * ground;
    const double length = std::sqrt(along.squaredNorm());
    if (wet != nullptr && length > 1e-9) {
      const Vec3 across(ground.cross(along) / length);
      const double turn = wet->turn(scene.frames, g.at, across);
      along = (along + (length * turn) * across) / std::sqrt(1.0 + turn * turn);
    }
    if (!scene.options.tangential_slowdown && length > 1e-9) along /= length;
    g.velocity = speed * (1.0 - behavior.deceleration_float) * along;
    g.state = GammatonState::Floating;
    g.position = scene.frames.point(g.at) + scene.options.epsilon_mm * ground;
  }
  const int level = response_detail::levelness(scene, ground);
  const double left = std::sqrt(g.velocity.squaredNorm());
  if (level > 0 && (left < scene.options.rest_speed_mm_s || left == 0.0)) return Outcome::Rested;
  if (level < 0 && !is_bounce) {
    // Downhill by less than 1 degree is no longer downhill.
    const double downhill = g.velocity.dot(scene.gravity) / std::sqrt(scene.gravity.squaredNorm());
    if (downhill <= 0.02 * left) {
      g.state = GammatonState::Flying;
      g.position = scene.frames.point(g.at) + scene.skin * ground;
    }
  }
  return Outcome::Alive;
}

}  // namespace patinate::simulation
