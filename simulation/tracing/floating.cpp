#include <Eigen/Geometry>
#include <cmath>

#include "simulation/tracing/pieces.h"

namespace patinate {

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

}  // namespace

PieceEnd float_on(const MotionScene& scene, Gammaton& g, std::int64_t& num_pieces) {
  const TracingOptions& o = scene.options;
  const Vec3 p = scene.frames.point(g.at);
  const Vec3 n = g.is_front ? scene.frames.normal(g.at.triangle) : Vec3(-scene.frames.normal(g.at.triangle));
  // Up from the surface, but through nothing.
  const Vec3 start = p + scene.skin * n;
  double hover = o.epsilon_mm;
  ++num_pieces;
  const TriangleHit above = scene.rays.first_hit(start, n, 0.0, o.epsilon_mm);
  if (above.triangle >= 0) hover = 0.5 * above.distance;
  const Vec3 from = start + hover * n;

  const Vec3 velocity = g.velocity - g.velocity.dot(n) * n;
  const Vec3 gravity = scene.gravity - scene.gravity.dot(n) * n;
  const double speed = std::sqrt(velocity.squaredNorm()), pull = std::sqrt(gravity.squaredNorm());
  const double length = hover < o.pull * o.reach_mm ? hover / o.pull : o.reach_mm;
  // As long as it takes for about `length`, and no longer than gravity alone would need.
  double duration = pull > 0.0 ? std::sqrt(2.0 * length / pull) : 0.0;
  if (speed > 0.0) {
    const double along = velocity.dot(gravity) / speed;
    const double discriminant = speed * speed + 2.0 * along * length;
    const double needed = discriminant >= 0.0 ? 2.0 * length / (speed + std::sqrt(discriminant)) : duration;
    if (pull == 0.0 || needed < duration) duration = needed;
  }
  const Vec3 step = duration * velocity + (0.5 * duration * duration) * gravity;
  const double step_length = std::sqrt(step.squaredNorm());
  if (!(step_length > 1e-9 * length)) return PieceEnd::Rested;  // nothing moves it
  const Vec3 ahead = step / step_length;

  const Vec3 way = ahead - o.pull * n;
  ++num_pieces;
  const TriangleHit hit = scene.rays.first_hit(from, way, 0.0, o.reach_mm);
  if (hit.triangle >= 0) {
    touch(scene, g, hit, velocity_after(hit.distance, ahead, velocity, gravity));
    return PieceEnd::Contact;
  }
  const Vec3 end = from + o.reach_mm * way;
  if (o.pull * o.reach_mm > hover) {
    const Vec3 back = p - 0.25 * o.epsilon_mm * n - end;
    ++num_pieces;
    const TriangleHit round = scene.rays.first_hit(end, back, 0.0, 1.0);
    if (round.triangle >= 0) {
      touch(scene, g, round, velocity);
      const Vec3 normal = g.is_front ? scene.frames.normal(round.triangle) : Vec3(-scene.frames.normal(round.triangle));
      const double square = speed * speed + 2.0 * scene.gravity.dot(g.position - p);  // what it falls by
      const Vec3 along = turned(speed > 0.0 ? Vec3(velocity / speed) : ahead, n, normal);
      g.velocity = std::sqrt(std::max(0.0, square)) * along;
      return PieceEnd::Contact;
    }
  }
  g.state = GammatonState::Flying;
  g.position = from;
  g.velocity = velocity;
  return PieceEnd::Flying;
}

}  // namespace patinate
