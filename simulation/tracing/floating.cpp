#include <algorithm>
#include <cmath>

#include "simulation/tracing/pieces.h"
#include "simulation/tracing/surface_walk.h"

namespace patinate::simulation {

namespace {

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

/// Lands on the triangle that it is on, if all of its way is above that one.
bool stays_above(const MotionScene& scene, Gammaton& g, const Step& step, double length) {
  const Vec2 change = scene.frames.weights_of(g.at.triangle, length * step.ahead);
  const SurfacePlace there{.triangle = g.at.triangle, .b1 = g.at.b1 + change.x(), .b2 = g.at.b2 + change.y()};
  if (!(there.b1 >= kLeastWeight && there.b2 >= kLeastWeight && there.b1 + there.b2 <= 1.0 - kLeastWeight))
    return false;
  g.at = there;
  return true;
}

/// Where nothing can be walked on: ahead and down until something is hit, or back below the place it came from; flies
/// when nothing is there either.
/// @param p  Point of the surface below it.
PieceEnd glide(const MotionScene& scene, Gammaton& g, const SurfaceRunner& runner, const Vec3& p, double hover,
               double epsilon, std::int64_t& num_pieces) {
  const TracingOptions& o = scene.options;
  const Vec3& n = runner.normal;
  const Vec3 gravity = scene.gravity - scene.gravity.dot(n) * n;
  const Vec3 from = p + (scene.skin + hover) * n;
  const Vec3 way = runner.ahead - o.pull * n;
  const TriangleHit hit = scene.rays.first_hit(from, way, 0.0, o.reach_mm);
  if (hit.triangle >= 0) {
    touch(scene, g, hit, velocity_after(hit.distance, runner.ahead, runner.velocity, gravity));
    return PieceEnd::Contact;
  }
  const Vec3 end = from + o.reach_mm * way;
  if (o.pull * o.reach_mm > hover) {
    ++num_pieces;
    const TriangleHit round = scene.rays.first_hit(end, p - 0.25 * epsilon * n - end, 0.0, 1.0);
    if (round.triangle >= 0) {
      touch(scene, g, round, runner.velocity);
      const Vec3 normal = g.is_front ? scene.frames.normal(round.triangle) : Vec3(-scene.frames.normal(round.triangle));
      const double square =
          runner.velocity.squaredNorm() + 2.0 * scene.gravity.dot(g.position - p);  // what it falls by
      const double speed = std::sqrt(runner.velocity.squaredNorm());
      g.velocity = std::sqrt(std::max(0.0, square)) *
                   turned(speed > 0.0 ? Vec3(runner.velocity / speed) : runner.ahead, n, normal);
      return PieceEnd::Contact;
    }
  }
  g.state = GammatonState::Flying;
  g.position = from;
  g.velocity = runner.velocity;
  return PieceEnd::Flying;
}

/// What is in the way of a piece that ends on the surface, or above it.
bool is_stopped(const MotionScene& scene, Gammaton& g, const SurfaceWalk& walk, const SurfaceWalk::Corner& from,
                const Vec3& to) {
  const Vec3 way = to - from.position;
  const TriangleHit hit = scene.rays.first_hit(from.position, way, 0.0, 1.0);
  if (hit.triangle < 0 || walk.has_walked_on(hit.triangle)) return false;
  const SurfaceRunner& runner = from.runner;
  const Vec3 gravity = scene.gravity - scene.gravity.dot(runner.normal) * runner.normal;
  const double length = std::max(0.0, hit.distance * way.dot(runner.ahead));
  touch(scene, g, hit, velocity_after(length, runner.ahead, runner.velocity, gravity));
  return true;
}

/// Along the surface, unless something else is in the way.
PieceEnd walk_on(const MotionScene& scene, Gammaton& g, const SurfaceRunner& from, double length, double hover,
                 double epsilon, std::int64_t& num_pieces) {
  const SurfaceWalk walk(scene, from, length, hover);
  if (walk.end() == SurfaceWalk::End::TooFar)
    return glide(scene, g, from, scene.frames.point(from.at), hover, epsilon, num_pieces);
  const auto corners = walk.corners();
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    if (is_stopped(scene, g, walk, corners[i], corners[i + 1].position)) return PieceEnd::Contact;
    ++num_pieces;
  }
  const SurfaceRunner& end = walk.runner();
  const Vec3 p = scene.frames.point(end.at);
  if (walk.end() == SurfaceWalk::End::Stopped) {
    if (corners.back().runner.at.triangle != end.at.triangle) {
      if (is_stopped(scene, g, walk, corners.back(), p + (scene.skin + walk.height()) * end.normal))
        return PieceEnd::Contact;
      ++num_pieces;
    }
    return glide(scene, g, end, p, walk.height(), epsilon, num_pieces);
  }
  if (is_stopped(scene, g, walk, corners.back(), p)) return PieceEnd::Contact;
  g.state = GammatonState::InContact;
  g.is_front = end.is_front;
  g.at = end.at;
  g.position = p;
  g.velocity = end.velocity;
  return PieceEnd::Contact;
}

}  // namespace

PieceEnd float_on(const MotionScene& scene, Gammaton& g, std::uint32_t random, std::int64_t& num_pieces) {
  const TracingOptions& o = scene.options;
  const double epsilon = o.epsilon_mm * (0.5 + static_cast<double>(random) * 0x1p-33);
  const Vec3 n = g.is_front ? scene.frames.normal(g.at.triangle) : Vec3(-scene.frames.normal(g.at.triangle));
  const bool comes_down = o.pull * o.reach_mm >= epsilon;
  const double length = comes_down ? epsilon / o.pull : o.reach_mm;
  ++num_pieces;
  const Step step = step_of(scene, g, n, length);
  if (step.ahead == Vec3::Zero()) return PieceEnd::Rested;  // nothing moves it
  const bool is_clear = scene.clearance.is_clear(g.at.triangle, g.is_front);
  if (comes_down && is_clear && stays_above(scene, g, step, length)) {
    g.state = GammatonState::InContact;
    g.velocity = velocity_after(length, step.ahead, step.velocity, step.gravity);
    g.position = scene.frames.point(g.at);
    return PieceEnd::Contact;
  }

  // Up from the surface, but through nothing.
  const Vec3 p = scene.frames.point(g.at);
  double hover = epsilon;
  if (!is_clear) {
    const TriangleHit above = scene.rays.first_hit(p + scene.skin * n, n, 0.0, epsilon);
    if (above.triangle >= 0) hover = 0.5 * above.distance;
  }
  const SurfaceRunner runner{
      .at = g.at, .is_front = g.is_front, .normal = n, .ahead = step.ahead, .velocity = step.velocity};
  if (!comes_down) return glide(scene, g, runner, p, hover, epsilon, num_pieces);
  return walk_on(scene, g, runner, length, hover, epsilon, num_pieces);
}

}  // namespace patinate::simulation
