/// \file
/// Rays against a mesh (Embree inside). For pictures, exposure and spray; never for what must be equal on every
/// machine.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "patinate/geometry/mesh.h"

namespace patinate {

struct RayHit {
  int triangle = -1;
  double b1 = 0.0;  ///< Barycentric weight of corner 1.
  double b2 = 0.0;  ///< Barycentric weight of corner 2.
  double distance = 0.0;
};

/// Immutable after construction; queries are thread-safe.
class RayScene {
 public:
  explicit RayScene(const Mesh& mesh);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /// First hit along a unit direction in [min_distance, max_distance], mesh units.
  [[nodiscard]] std::optional<RayHit> first_hit(const Vec3& origin, const Vec3& direction, double min_distance = 0.0,
                                                double max_distance = 1e30) const;
  /// Whether anything lies along a unit direction within `max_distance`, mesh units.
  [[nodiscard]] bool is_blocked_along(const Vec3& origin, const Vec3& direction, double max_distance = 1e30) const;
  /// Whether anything lies on the segment, its ends shortened by `epsilon`.
  [[nodiscard]] bool is_blocked(const Vec3& from, const Vec3& to, double epsilon) const;
  /// Whether anything lies within `max_distance` along one unit direction from each of at most 8 points, which should
  /// be near each other: bit i is set for origins[i]. Several times as fast as one by one.
  [[nodiscard]] unsigned blocked_of_8(std::span<const Vec3> origins, const Vec3& direction, double max_distance) const;
  /// The same from one point along at most 8 unit directions, each within its own distance.
  [[nodiscard]] unsigned blocked_of_8(const Vec3& origin, std::span<const Vec3> directions,
                                      std::span<const double> max_distances) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace patinate
