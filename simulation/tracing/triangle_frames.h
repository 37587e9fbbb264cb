/// \file
/// What gammatons need of a triangle besides being hit: its plane, and how barycentric weights change along it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "patinate/simulation/surface_atlas.h"
#include "simulation/tracing/ray_tracer.h"

namespace patinate::simulation {

/// A place on a triangle.
struct SurfacePlace {
  std::int32_t triangle = -1;
  double b1 = 0.0, b2 = 0.0;
};

/// Of each triangle as RayTracer has it (corners rounded to float), in plain floats. 72 bytes a triangle, and 36 for
/// normals.
class TriangleFrames {
 public:
  TriangleFrames(const SceneMesh& scene_mesh, const RayTracer& tracer);

  [[nodiscard]] std::int64_t num_triangles() const { return static_cast<std::int64_t>(frames_.size()); }
  /// Asks for what is needed of a triangle soon; -1: nothing.
  void prefetch([[maybe_unused]] int triangle) const {
#if defined(__GNUC__)
    if (triangle < 0) return;
    const auto* frame = reinterpret_cast<const char*>(&frames_[static_cast<std::size_t>(triangle)]);
    __builtin_prefetch(frame);
    __builtin_prefetch(frame + sizeof(TriangleFrame) - 1);
    if (!corner_normals_.empty()) __builtin_prefetch(&corner_normals_[static_cast<std::size_t>(triangle)]);
#endif
  }

  [[nodiscard]] Vec3 point(const SurfacePlace& at) const;
  /// Unit normal; 0 for a triangle without area.
  [[nodiscard]] Vec3 normal(int triangle) const { return wide(frames_[static_cast<std::size_t>(triangle)].normal); }
  /// The mesh's normals interpolated; unit; the triangle's where these cancel.
  [[nodiscard]] Vec3 shading_normal(const SurfacePlace& at) const;
  /// Change of b1 and b2 over a step along the triangle.
  [[nodiscard]] Vec2 weights_of(int triangle, const Vec3& step) const {
    const TriangleFrame& f = frames_[static_cast<std::size_t>(triangle)];
    return {step.dot(wide(f.gradient_1)), step.dot(wide(f.gradient_2))};
  }
  /// Signed distance from the triangle's plane, along its normal.
  [[nodiscard]] double height(int triangle, const Vec3& p) const {
    return (p - corner(triangle, 0)).dot(normal(triangle));
  }
  [[nodiscard]] Vec3 corner(int triangle, std::size_t k) const {
    return wide(frames_[static_cast<std::size_t>(triangle)].corner[k]) + center_;
  }

 private:
  using Float3 = std::array<float, 3>;
  struct TriangleFrame {
    std::array<Float3, 3> corner;  ///< Relative to center_.
    Float3 normal;
    Float3 gradient_1;  ///< Of b1, per mm.
    Float3 gradient_2;
  };
  static Vec3 wide(const Float3& v) {
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
  }

  Vec3 center_;
  std::vector<TriangleFrame> frames_;
  std::vector<std::array<Float3, 3>> corner_normals_;
};

/// Contacts keep this far, in barycentric weights, from the edges of their triangles.
inline constexpr double kLeastWeight = 1e-6;

/// The same place, moved into its triangle by that: what starts there is on the right side of all triangles around.
[[nodiscard]] inline SurfacePlace moved_inside(SurfacePlace at) {
  at.b1 = at.b1 > kLeastWeight ? at.b1 : kLeastWeight;
  at.b2 = at.b2 > kLeastWeight ? at.b2 : kLeastWeight;
  const double sum = at.b1 + at.b2;
  if (sum > 1.0 - kLeastWeight) {
    at.b1 *= (1.0 - kLeastWeight) / sum;
    at.b2 *= (1.0 - kLeastWeight) / sum;
  }
  return at;
}

}  // namespace patinate::simulation
