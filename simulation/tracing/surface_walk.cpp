#include "simulation/tracing/surface_walk.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patinate::simulation {

namespace {
constexpr double kSteepest = 0.70710678118654752;  // cosine of the steepest rise that is walked up
}

Vec3 turned(const Vec3& velocity, const Vec3& from, const Vec3& to) {
  const double cosine = from.dot(to);
  if (cosine < -0.999) return -velocity;  // round the edge of a thin plate
  const Vec3 axis = from.cross(to);
  return velocity * cosine + axis.cross(velocity) + axis * (axis.dot(velocity) / (1.0 + cosine));
}

Vec3 velocity_after(double way, const Vec3& direction, const Vec3& velocity, const Vec3& acceleration) {
  const double b = direction.dot(velocity), a = 0.5 * direction.dot(acceleration);
  const double root = std::sqrt(std::max(0.0, b * b + 4.0 * a * way));
  const double time = b + root > 0.0 ? 2.0 * way / (b + root) : 0.0;
  return velocity + time * acceleration;
}

SurfaceWalk::SurfaceWalk(const MotionScene& scene, const SurfaceRunner& from, double length, double hover)
    : runner_(from), height_(hover), slope_(hover / length), least_cosine_(1.0 / std::sqrt(1.0 + slope_ * slope_)) {
  add_corner(scene.frames.point(from.at) + hover * from.normal);
  triangles_[num_triangles_++] = from.at.triangle;
  double left = length;
  while (true) {
    const SurfacePlace& at = runner_.at;
    const Vec2 rate = scene.frames.weights_of(at.triangle, runner_.ahead);
    const std::array<double, 3> rates{-rate.x() - rate.y(), rate.x(), rate.y()};
    std::array<double, 3> weights{1.0 - at.b1 - at.b2, at.b1, at.b2};
    std::size_t exit = 3;
    double way = left;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(rates[k] < 0.0) || k == entered_over_) continue;
      const double until = std::max(0.0, weights[k] / -rates[k]);
      if (until < way) {
        way = until;
        exit = k;
      }
    }
    for (std::size_t k = 0; k < 3; ++k) weights[k] = std::max(0.0, weights[k] + way * rates[k]);
    if (exit == 3) {
      const Vec3 gravity = scene.gravity - scene.gravity.dot(runner_.normal) * runner_.normal;
      runner_.velocity = velocity_after(way, runner_.ahead, runner_.velocity, gravity);
      runner_.at = moved_inside({.triangle = at.triangle, .b1 = weights[1], .b2 = weights[2]});
      height_ = 0.0;
      return;
    }
    if (num_triangles_ == kMostTriangles || num_corners_ == kMostCorners) {
      end_ = End::TooFar;
      return;
    }
    if (!cross(scene, exit, weights, way)) {
      end_ = End::Stopped;
      return;
    }
    left -= way;
  }
}

bool SurfaceWalk::cross(const MotionScene& scene, std::size_t k, const std::array<double, 3>& weights, double way) {
  const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
  const SurfaceLinks::Link link = scene.links.across(runner_.at.triangle, i);
  if (link.triangle < 0) return false;
  const bool is_front = runner_.is_front != link.is_turned;
  const Vec3 normal = is_front ? scene.frames.normal(link.triangle) : Vec3(-scene.frames.normal(link.triangle));
  if (normal == Vec3::Zero()) return false;
  const bool falls = normal.dot(runner_.ahead) >= 0.0;
  if (!falls && normal.dot(runner_.normal) < kSteepest) return false;

  const double sum = weights[i] + weights[j];
  const double share = sum > 0.0 ? weights[j] / sum : 0.5;
  const Vec3 gravity = scene.gravity - scene.gravity.dot(runner_.normal) * runner_.normal;
  const Vec3 velocity = velocity_after(way, runner_.ahead, runner_.velocity, gravity);
  const Vec3 before = runner_.normal;
  Vec3 ahead = turned(runner_.ahead, before, normal);
  ahead -= ahead.dot(normal) * normal;
  const double length = std::sqrt(ahead.squaredNorm());
  if (!(length > 0.5)) return false;

  // The corner `edge` is this edge's end, or its beginning where the other triangle is turned.
  std::array<double, 3> there{};
  there[link.edge] = link.is_turned ? 1.0 - share : share;
  there[(link.edge + 1) % 3] = link.is_turned ? share : 1.0 - share;
  const Vec3 was_ahead = runner_.ahead;
  runner_ = {.at = {.triangle = link.triangle, .b1 = there[1], .b2 = there[2]},
             .is_front = is_front,
             .normal = normal,
             .ahead = ahead / length,
             .velocity = falls ? turned(velocity, before, normal) : velocity};
  runner_.velocity -= runner_.velocity.dot(normal) * normal;
  entered_over_ = (link.edge + 2) % 3;
  height_ -= slope_ * way;
  triangles_[num_triangles_++] = link.triangle;
  // A piece falls by its slope. What bends down by more than that would be cut.
  if (falls && corners_[num_corners_ - 1].runner.normal.dot(normal) < least_cosine_) {
    const Vec3 middle = before + normal;
    const double middle_length = std::sqrt(middle.squaredNorm());
    add_corner(scene.frames.point(runner_.at) +
               height_ * (middle_length > 0.1 ? Vec3(middle / middle_length) : was_ahead));
  }
  return true;
}

void SurfaceWalk::add_corner(const Vec3& position) {
  corners_[num_corners_++] = {.position = position, .runner = runner_};
}

bool SurfaceWalk::has_walked_on(int triangle) const {
  const auto walked = std::span(triangles_).first(num_triangles_);
  return std::find(walked.begin(), walked.end(), triangle) != walked.end();
}

}  // namespace patinate::simulation
