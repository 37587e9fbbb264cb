#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "simulation/tracing/pieces.h"

namespace patinate::simulation {

namespace {

/// Velocity after `way` along the unit direction, under an acceleration: t solves direction . (v t + a t^2 / 2) = way.
Vec3 velocity_after(double way, const Vec3& direction, const Vec3& velocity, const Vec3& acceleration) {
  const double b = direction.dot(velocity), a = 0.5 * direction.dot(acceleration);
  const double root = std::sqrt(std::max(0.0, b * b + 4.0 * a * way));
  const double time = b + root > 0.0 ? 2.0 * way / (b + root) : 0.0;
  return velocity + time * acceleration;
}

/// Velocity along one surface as it is along another that meets it: turned with the normal, the shortest way.
Vec3 turned(const Vec3& velocity, const Vec3& from, const Vec3& to) {
  const double cosine = from.dot(to);
  if (cosine < -0.999) return -velocity;  // round the edge of a thin plate
  const Vec3 axis = from.cross(to);
  return velocity * cosine + axis.cross(velocity) + axis * (axis.dot(velocity) / (1.0 + cosine));
}

void touch(const MotionScene& scene, Gammaton& g, const TriangleHit& hit, const Vec3& velocity) {
  g.state = GammatonState::InContact;
  g.is_front = hit.is_front;
  g.at = moved_inside({.triangle = hit.triangle, .b1 = hit.b1, .b2 = hit.b2});
  g.position = scene.frames.point(g.at);
  g.velocity = velocity;
}

/// How far a floating gammaton gets along the tangent plane, and which way.
struct Step {
  Vec3 ahead{0, 0, 0};                       ///< Unit; 0 when nothing moves it.
  Vec3 velocity{0, 0, 0}, gravity{0, 0, 0};  ///< Tangential.
};

/// The direction in which it is after about `length`: as long as that takes, and no longer than gravity alone would
/// need.
Step step_of(const MotionScene& scene, const Gammaton& g, const Vec3& n, double length) {
  Step step{.velocity = g.velocity - g.velocity.dot(n) * n, .gravity = scene.gravity - scene.gravity.dot(n) * n};
  const double speed = std::sqrt(step.velocity.squaredNorm()), pull = std::sqrt(step.gravity.squaredNorm());
  double duration = pull > 0.0 ? std::sqrt(2.0 * length / pull) : 0.0;
  if (speed > 0.0) {
    const double discriminant = speed * speed + 2.0 * length * step.velocity.dot(step.gravity) / speed;
    const double needed = discriminant >= 0.0 ? 2.0 * length / (speed + std::sqrt(discriminant)) : duration;
    if (pull == 0.0 || needed < duration) duration = needed;
  }
  const Vec3 way = duration * step.velocity + (0.5 * duration * duration) * step.gravity;
  const double way_length = std::sqrt(way.squaredNorm());
  if (way_length > 1e-9 * length) step.ahead = way / way_length;
  return step;
}

/// Lands on the triangle that it is on, if all of its way is above that one and nothing else is there.
bool stays_above(const MotionScene& scene, Gammaton& g, const Step& step, double length) {
  const Vec2 change = scene.frames.weights_of(g.at.triangle, length * step.ahead);
  const SurfacePlace there{.triangle = g.at.triangle, .b1 = g.at.b1 + change.x(), .b2 = g.at.b2 + change.y()};
  if (!(there.b1 >= kLeastWeight && there.b2 >= kLeastWeight && there.b1 + there.b2 <= 1.0 - kLeastWeight))
    return false;
  if (!scene.clearance.is_clear(g.at.triangle, g.is_front)) return false;
  g.at = there;
  return true;
}

}  // namespace

PieceEnd float_on(const MotionScene& scene, Gammaton& g, std::uint32_t random, std::int64_t& num_pieces) {
  const TracingOptions& o = scene.options;
  const double epsilon = o.epsilon_mm * (0.5 + static_cast<double>(random) * 0x1p-33);
  const Vec3 n = g.is_front ? scene.frames.normal(g.at.triangle) : Vec3(-scene.frames.normal(g.at.triangle));
  const double length = std::min(epsilon, o.pull * o.reach_mm) / o.pull;
  ++num_pieces;
  Step step = step_of(scene, g, n, o.pull > 0.0 ? length : o.reach_mm);
  if (step.ahead == Vec3::Zero()) return PieceEnd::Rested;  // nothing moves it
  if (o.pull * o.reach_mm >= epsilon && stays_above(scene, g, step, length)) {
    g.state = GammatonState::InContact;
    g.velocity = velocity_after(length, step.ahead, step.velocity, step.gravity);
    g.position = scene.frames.point(g.at);
    return PieceEnd::Contact;
  }

  // Up from the surface, but through nothing.
  const Vec3 p = scene.frames.point(g.at);
  const Vec3 start = p + scene.skin * n;
  double hover = epsilon;
  if (!scene.clearance.is_clear(g.at.triangle, g.is_front)) {
    const TriangleHit above = scene.rays.first_hit(start, n, 0.0, epsilon);
    if (above.triangle >= 0) hover = 0.5 * above.distance;
  }
  const Vec3 from = start + hover * n;
  const Vec3 way = step.ahead - o.pull * n;
  const TriangleHit hit = scene.rays.first_hit(from, way, 0.0, o.reach_mm);
  if (hit.triangle >= 0) {
    touch(scene, g, hit, velocity_after(hit.distance, step.ahead, step.velocity, step.gravity));
    return PieceEnd::Contact;
  }
  const Vec3 end = from + o.reach_mm * way;
  if (o.pull * o.reach_mm > hover) {
    ++num_pieces;
    const TriangleHit round = scene.rays.first_hit(end, p - 0.25 * epsilon * n - end, 0.0, 1.0);
    if (round.triangle >= 0) {
      touch(scene, g, round, step.velocity);
      const Vec3 normal = g.is_front ? scene.frames.normal(round.triangle) : Vec3(-scene.frames.normal(round.triangle));
      const double square = step.velocity.squaredNorm() + 2.0 * scene.gravity.dot(g.position - p);  // what it falls by
      const double speed = std::sqrt(step.velocity.squaredNorm());
      g.velocity =
          std::sqrt(std::max(0.0, square)) * turned(speed > 0.0 ? Vec3(step.velocity / speed) : step.ahead, n, normal);
      return PieceEnd::Contact;
    }
  }
  g.state = GammatonState::Flying;
  g.position = from;
  g.velocity = step.velocity;
  return PieceEnd::Flying;
}

}  // namespace patinate::simulation
