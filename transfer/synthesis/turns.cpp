#include "transfer/synthesis/turns.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

namespace patinate::transfer {

namespace {

std::array<std::int32_t, kSineSteps> make_sines() {
  std::array<std::int32_t, kSineSteps> sines{};
  for (int k = 0; k < kSineSteps; ++k) {
    const double value = std::sin(2.0 * std::numbers::pi * k / kSineSteps);
    sines[k] = static_cast<std::int32_t>(std::floor(value * (1 << kSineBits) + 0.5));
  }
  return sines;
}
}  // namespace

const std::array<std::int32_t, kSineSteps> kSines = make_sines();

double radians_of(Turn turn) { return 2.0 * std::numbers::pi * turn / kFullTurn; }

Turn turn_of(double radians) {
  return sum_of(static_cast<int>(std::lround(radians / (2.0 * std::numbers::pi) * kFullTurn)), 0);
}

FrameTurns::FrameTurns(const Mesh& mesh, const FlowFrames& frames) : frames_(frames) {
  normals_.reserve(frames.size());
  for (std::size_t k = 0; k < frames.size(); ++k) normals_.push_back(frames[k].col(0).cross(frames[k].col(1)));
  for (const std::array<int, 3>& triangles : triangle_neighbors(mesh)) {
    const int a = static_cast<int>(beside_.size());
    Beside& beside = beside_.emplace_back(Beside{triangles});
    for (std::size_t k = 0; k < 3; ++k) {
      if (triangles[k] >= 0) beside.turns[k] = found_between(a, triangles[k]);
    }
  }
}

Turn FrameTurns::found_between(int a, int b) const {
  const FlowFrame &in_a = frames_[a], &in_b = frames_[b];
  const Vec3 &to = normals_[a], &from = normals_[b];
  const Vec3 axis = from.cross(to);
  const double c = from.dot(to);
  constexpr double kFolded = 1e-3;  // Share of 1 + c: a fold by almost half a turn has no shortest way.
  if (!(1.0 + c > kFolded)) return 0;
  const Vec3 x = in_b.col(0), across = axis.cross(x), tilted = x + across + axis.cross(across) / (1.0 + c);
  return turn_of(std::atan2(in_a.col(1).dot(tilted), in_a.col(0).dot(tilted)));
}

}  // namespace patinate::transfer
