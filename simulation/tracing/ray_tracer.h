/// \file
/// First hits of rays on a scene's triangles: the same bits on every processor and compiler, from plain arrays that a
/// GPU can share. Embree's (libcommon/geometry/ray_scene.h) depend on the instruction set that it picks;
/// docs/decisions/0007-own-ray-tracer.md.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate::simulation {

/// Four boxes, by lane, relative to RayTracer::center(). 128 bytes.
struct alignas(64) BvhNode {
  std::array<std::array<std::array<float, 4>, 3>, 2>
      bounds;                         ///< [low, high][axis][lane]; low > high in a lane without child.
  std::array<std::int32_t, 4> child;  ///< >= 0: a node. < 0: block -1 - child. Unused lanes: 0.
  std::array<std::int32_t, 4> padding;
};

/// Up to four triangles, by lane, relative to RayTracer::center(). 160 bytes.
struct alignas(32) TriangleBlock {
  std::array<std::array<std::array<float, 4>, 3>, 3>
      corner;                            ///< [corner][axis][lane]; unused lanes repeat the first triangle.
  std::array<std::int32_t, 4> triangle;  ///< Index in the mesh; unused lanes -1.
};

struct TriangleHit {
  int triangle = -1;  ///< -1: nothing was hit.
  double b1 = 0.0;    ///< Barycentric weights of corners 1 and 2; with that of corner 0 all in [0, 1].
  double b2 = 0.0;
  double distance = 0.0;  ///< In lengths of the direction.
  bool is_front = true;   ///< The triangle's normal faces the ray.
};

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
  /// The same by asking every triangle: the truth of tests.
  [[nodiscard]] TriangleHit first_hit_of_all(const Vec3& origin, const Vec3& direction, double min_distance,
                                             double max_distance) const;

  /// Whether there is no triangle, of those whose boxes' leaf may meet `box`, that `stops(triangle)` holds for.
  [[nodiscard]] bool none_in_box(const Box& box, const std::function<bool(int)>& stops) const;

  /// Box of all triangles, as rounded.
  [[nodiscard]] const Box& box() const { return box_; }
  [[nodiscard]] const Vec3& center() const { return center_; }
  /// A coordinate as its triangles have it: rounded to float relative to center().
  [[nodiscard]] Vec3 rounded(const Vec3& p) const { return (p - center_).cast<float>().cast<double>() + center_; }
  /// The first one is the root; empty without triangles.
  [[nodiscard]] std::span<const BvhNode> nodes() const { return nodes_; }
  [[nodiscard]] std::span<const TriangleBlock> blocks() const { return blocks_; }

 private:
  Vec3 center_ = Vec3::Zero();
  Box box_;
  Vec3 low_ = Vec3::Zero(), high_ = Vec3::Zero();  ///< The box, a little larger, relative to center_.
  float slack_ = 0.0F;                             ///< What rounding to float may move a coordinate by.
  std::vector<BvhNode> nodes_;
  std::vector<TriangleBlock> blocks_;
};

}  // namespace patinate::simulation
