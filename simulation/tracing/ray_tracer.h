/// \file
/// First hits of rays on a scene's triangles: the same bits on every processor and compiler, from plain arrays that a
/// GPU can share. Embree's (libcommon/geometry/ray_scene.h) depend on the instruction set that it picks;
/// docs/decisions/0007-own-ray-tracer.md.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "libcommon/core/kernel_language.h"
#include "patinate/geometry/mesh.h"

namespace patinate::simulation {

/// ray_types.inl for C++; devices read the same text.
namespace ray_types {
using namespace kernel_types;
#include "simulation/tracing/ray_types.inl"
}  // namespace ray_types
using ray_types::BvhNode;
using ray_types::RayFrame;
using ray_types::TriangleBlock;
using ray_types::TriangleHit;

/// A bounding volume hierarchy, four children a node, by the surface area heuristic in 16 bins [Wald 2007], over
/// triangles whose corners are rounded to float once (relative 6e-8 of the scene's size; equal positions stay equal).
/// Boxes are tested in float, on the safe side; what may be hit is decided in double by signs of products of shared
/// corners [Woop, Benthin, Wald 2013], which are right or zero, and zero counts as inside: no ray passes between
/// triangles that share an edge or a corner. Uses + - * / and comparisons alone. Immutable after construction; queries
/// are thread-safe.
class RayTracer {
 public:
  /// @param mesh  Finite positions. Triangles without area are never hit. May be empty.
  explicit RayTracer(const Mesh& mesh);

  /// First hit at a distance in (min_distance, max_distance], 0 <= min_distance, along any direction that is not 0,
  /// from both sides; of several at the same distance that of the lowest index. A direction or origin that is not
  /// finite, or lengths beyond 1e100 and below 1e-100, hit nothing.
  [[nodiscard]] TriangleHit first_hit(const Vec3& origin, const Vec3& direction, double min_distance,
                                      double max_distance) const;
  /// First hit by asking every triangle: the truth of tests.
  [[nodiscard]] TriangleHit first_hit_of_all(const Vec3& origin, const Vec3& direction, double min_distance,
                                             double max_distance) const;

  /// Whether there is no triangle, of those whose boxes' leaf may meet `box`, that `stops(triangle)` holds for.
  [[nodiscard]] bool none_in_box(const Box& box, const std::function<bool(int)>& stops) const;

  /// Box of all triangles, as rounded.
  [[nodiscard]] const Box& box() const { return box_; }
  [[nodiscard]] const Vec3& center() const { return center_; }
  [[nodiscard]] const RayFrame& frame() const { return frame_; }
  /// A coordinate as its triangles have it: rounded to float relative to center().
  [[nodiscard]] Vec3 rounded(const Vec3& p) const { return (p - center_).cast<float>().cast<double>() + center_; }
  /// The first one is the root; empty without triangles.
  [[nodiscard]] std::span<const BvhNode> nodes() const { return nodes_; }
  [[nodiscard]] std::span<const TriangleBlock> blocks() const { return blocks_; }

 private:
  Vec3 center_ = Vec3::Zero();
  Box box_;
  RayFrame frame_{};
  std::vector<BvhNode> nodes_;
  std::vector<TriangleBlock> blocks_;
};

}  // namespace patinate::simulation
