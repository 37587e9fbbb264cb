/// \file
/// What gammatons need of a triangle besides being hit: its plane, and how barycentric weights change along it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patinate/simulation/surface_atlas.h"
#include "simulation/tracing/motion_facts.h"

namespace patinate::simulation {

/// Frame of each triangle as RayTracer has it (corners rounded to float), in plain floats. 72 bytes a triangle, and 36
/// for normals.
class TriangleFrames {
 public:
  TriangleFrames(const SceneMesh& scene_mesh, const RayTracer& tracer);

  [[nodiscard]] std::int64_t num_triangles() const { return static_cast<std::int64_t>(frames_.size()); }
  /// Asks for what is needed of a triangle soon; -1: nothing.
  void prefetch([[maybe_unused]] int triangle) const {
#if defined(__GNUC__)
    if (triangle < 0) return;
    const auto* frame = reinterpret_cast<const char*>(&frames_[triangle]);
    __builtin_prefetch(frame);
    __builtin_prefetch(frame + sizeof(TriangleFrame) - 1);
    if (!corner_normals_.empty()) __builtin_prefetch(&corner_normals_[triangle]);
#endif
  }

  [[nodiscard]] Vec3 corner(int triangle, std::size_t k) const {
    const auto& c = frames_[triangle].corner[k];
    return Vec3(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])) + center_;
  }
  [[nodiscard]] const Vec3& center() const { return center_; }
  [[nodiscard]] std::span<const TriangleFrame> frames() const { return frames_; }
  /// The mesh's normals; empty without.
  [[nodiscard]] std::span<const CornerNormals> corner_normals() const { return corner_normals_; }

 private:
  Vec3 center_;
  std::vector<TriangleFrame> frames_;
  std::vector<CornerNormals> corner_normals_;
};

}  // namespace patinate::simulation
