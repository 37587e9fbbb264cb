/// \file
/// A straight way over a surface: on from triangle to triangle as if they were laid flat.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "simulation/tracing/pieces.h"

namespace patinate::simulation {

/// Where something runs on a surface, and how.
struct SurfaceRunner {
  SurfacePlace at;
  bool is_front = true;
  Vec3 normal{0, 0, 0};    ///< Of the triangle, on the side it is on; unit.
  Vec3 ahead{0, 0, 0};     ///< Unit, tangential.
  Vec3 velocity{0, 0, 0};  ///< mm/s, tangential.
};

/// Velocity along one surface as it is along another that meets it: turned with the normal, the shortest way.
[[nodiscard]] Vec3 turned(const Vec3& velocity, const Vec3& from, const Vec3& to);
/// Velocity after `way` along the unit direction, under an acceleration: t solves direction . (v t + a t^2 / 2) = way.
[[nodiscard]] Vec3 velocity_after(double way, const Vec3& direction, const Vec3& velocity, const Vec3& acceleration);

class SurfaceWalk {
 public:
  static constexpr std::size_t kMostTriangles = 16, kMostCorners = 6;

  /// What lies above the way, as a chain of straight pieces: from a height that falls evenly to 0 at the way's end.
  struct Corner {
    Vec3 position{0, 0, 0};
    SurfaceRunner runner;  ///< Below it.
  };

  enum class End {
    Arrived,
    Stopped,  ///< At the edge of the last triangle: the surface ends there, or rises by more than 45 degrees.
    TooFar    ///< Over more triangles than kMostTriangles, or more than kMostCorners sharp edges.
  };

  /// Runs `length` mm (> 0) straight ahead, over any edge that falls off, and over edges that rise by at most 45
  /// degrees: beyond that more of what runs into the slope is stopped by it than goes up.
  /// @param hover  Height at the beginning, mm.
  SurfaceWalk(const MotionScene& scene, const SurfaceRunner& from, double length, double hover);

  [[nodiscard]] End end() const { return end_; }
  /// At the end of the way; Stopped: where it came onto the last triangle.
  [[nodiscard]] const SurfaceRunner& runner() const { return runner_; }
  /// Height there, mm.
  [[nodiscard]] double height() const { return height_; }
  /// From the beginning on; the way leads from the last one straight to the end, and all pieces are free of the
  /// triangles that were walked on, since there is one wherever the surface falls off by more than a piece sinks.
  [[nodiscard]] std::span<const Corner> corners() const { return std::span(corners_).first(num_corners_); }
  [[nodiscard]] bool has_walked_on(int triangle) const;

 private:
  /// Onto the triangle across from corner k, after `way` on this one. @returns whether it can.
  bool cross(const MotionScene& scene, std::size_t k, const std::array<double, 3>& weights, double way);
  void add_corner(const Vec3& position);

  SurfaceRunner runner_;
  End end_ = End::Arrived;
  double height_ = 0.0;
  double slope_ = 0.0;         ///< By which pieces sink.
  double least_cosine_ = 0.0;  ///< Of the angle by which the surface may fall off below a piece.
  std::array<Corner, kMostCorners> corners_;
  std::size_t num_corners_ = 0;
  std::array<int, kMostTriangles> triangles_{};
  std::size_t num_triangles_ = 0;
  std::size_t entered_over_ = 3;  ///< Corner of the triangle across from the edge that it came over; 3: none.
};

}  // namespace patinate::simulation
