#include <algorithm>
#include <cmath>

#include "libcommon/core/portable_math.h"
#include "simulation/tracing/pieces.h"

namespace patinate::simulation {

namespace {

constexpr double kNever = -1.0;
constexpr double kEdge = 1e-6;  // of barycentric weights: rounding of gradients, and what moved_inside() takes back

/// Smallest time > 0 at which v t + a t^2 / 2 = way > 0; kNever if there is none.
double time_to(double way, double v, double a) {
  const double discriminant = v * v + 2.0 * a * way;
  if (discriminant < 0.0) return kNever;
  const double root = std::sqrt(discriminant);
  if (v > 0.0) return 2.0 * way / (v + root);
  return a > 0.0 ? (root - v) / a : kNever;
}

/// Time until it can be in the grown box of all triangles: 0 inside, kNever when it will not be again.
double time_to_box(const MotionScene& scene, const Gammaton& g) {
  const Box& box = scene.rays.box();
  const double margin = 1e-3 * box.diagonal() + 1e-6;
  double time = 0.0;
  for (Eigen::Index a = 0; a < 3; ++a) {
    const double below = box.low[a] - g.position[a], above = g.position[a] - box.high[a];
    double wait = 0.0;
    if (below > 2.0 * margin) wait = time_to(below - margin, g.velocity[a], scene.gravity[a]);
    if (above > 2.0 * margin) wait = time_to(above - margin, -g.velocity[a], -scene.gravity[a]);
    if (wait == kNever) return kNever;
    time = std::max(time, wait);
  }
  return time;
}

void advance(Gammaton& g, const Vec3& gravity, double time) {
  g.position += time * g.velocity + (0.5 * time * time) * gravity;
  g.velocity += time * gravity;
}

/// Puts it onto the triangle that its chord has hit, at `time` or, on the parabola, at about that.
void touch(const MotionScene& scene, Gammaton& g, const TriangleHit& hit, double time, double duration) {
  g.state = GammatonState::InContact;
  g.is_front = hit.is_front;
  g.at = {.triangle = hit.triangle, .b1 = hit.b1, .b2 = hit.b2};
  const Vec3 n = scene.frames.normal(hit.triangle);
  const double c = scene.frames.height(hit.triangle, g.position), b = n.dot(g.velocity), a = 0.5 * n.dot(scene.gravity);
  double exact = time;
  for (int k = 0; k < 3; ++k) {
    const double slope = b + 2.0 * a * exact;
    if (slope != 0.0) exact -= (c + (b + a * exact) * exact) / slope;
  }
  if (exact >= 0.0 && exact <= duration) {
    const Vec3 p = g.position + exact * g.velocity + (0.5 * exact * exact) * scene.gravity;
    const Vec2 w = scene.frames.weights_of(hit.triangle, p - scene.frames.corner(hit.triangle, 0));
    if (w.x() >= -kEdge && w.y() >= -kEdge && w.sum() <= 1.0 + kEdge) {
      g.at.b1 = w.x();
      g.at.b2 = w.y();
      time = exact;
    }
  }
  g.velocity += time * scene.gravity;
  g.at = moved_inside(g.at);
  g.position = scene.frames.point(g.at);
}

}  // namespace

MotionScene motion_scene(const Scene& scene, const RayTracer& rays, const TriangleFrames& frames,
                         const SurfaceLinks& links, const FreeSpace& free_space, Clearance& clearance) {
  return {.rays = rays,
          .frames = frames,
          .links = links,
          .free_space = free_space,
          .clearance = clearance,
          .options = scene.tracing,
          .gravity = scene.gravity_mm_s2,
          .skin = 1e-9 * rays.box().diagonal(),
          .rest_cosine = portable_sine_cosine(scene.tracing.rest_slope_deg / 360.0).cosine};
}

PieceEnd fly(const MotionScene& scene, Gammaton& g) {
  const double wait = time_to_box(scene, g);
  if (wait == kNever || !g.position.allFinite() || !g.velocity.allFinite()) return PieceEnd::Left;
  if (wait > 0.0) {
    advance(g, scene.gravity, wait);
    return PieceEnd::Flying;
  }
  const double pull = std::sqrt(scene.gravity.squaredNorm()), speed = std::sqrt(g.velocity.squaredNorm());
  if (pull == 0.0 && speed == 0.0) return PieceEnd::Rested;
  // No longer than to the other end of the scene.
  const double size = 2.0 * scene.rays.box().diagonal() + 1e-6;
  double duration = pull > 0.0 ? std::sqrt(8.0 * scene.options.epsilon_mm / pull) : size / speed;
  if (speed * duration > size) duration = size / speed;
  if (const double way = scene.free_space.distance(g.position); way > 0.0) {
    const double v = g.velocity.cwiseAbs().maxCoeff(), a = scene.gravity.cwiseAbs().maxCoeff();
    const double time = 2.0 * way / (v + std::sqrt(v * v + 2.0 * a * way));
    if (time >= duration) {
      advance(g, scene.gravity, time);
      return PieceEnd::Flying;
    }
  }
  const Vec3 chord = duration * g.velocity + (0.5 * duration * duration) * scene.gravity;
  const TriangleHit hit = scene.rays.first_hit(g.position, chord, 0.0, 1.0);
  if (hit.triangle < 0) {
    advance(g, scene.gravity, duration);
    return PieceEnd::Flying;
  }
  touch(scene, g, hit, hit.distance * duration, duration);
  return PieceEnd::Contact;
}

}  // namespace patinate::simulation
