/// \file
/// What a scanner saw along each of its lines of sight: a wrong pose puts surface in front of it, where the scanner saw
/// through.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "patinate/geometry/rigid_transform.h"

namespace patinate::capture {

/// Depths of a scan as its scanner saw them, in square cells across the lines of sight.
class LinesOfSight {
 public:
  /// @param scanner         Where it stood; or nothing, and then
  /// @param toward_scanner  unit, the same for all points. @param cell  > 0, at least the points' spacing.
  LinesOfSight(std::span<const Vec3> points, const std::optional<Vec3>& scanner, const Vec3& toward_scanner,
               double cell);

  enum class Seen { Nothing, Front, Surface, Behind };
  /// Where a point lies with respect to what was seen in its cell and the 8 around: nothing was seen in its cell; in
  /// front of all of it by more than `tolerance`; behind all of it by more; or on it.
  [[nodiscard]] Seen look_at(const Vec3& p, double tolerance) const;

 private:
  struct Depths {
    double nearest;  ///< Towards the scanner.
    double farthest;
  };
  [[nodiscard]] Vec3 across_and_depth(const Vec3& p) const;
  [[nodiscard]] static std::uint64_t key(std::int64_t x, std::int64_t y) {
    return (static_cast<std::uint64_t>(x) << 32) ^ (static_cast<std::uint64_t>(y) & 0xFFFFFFFFu);
  }
  std::optional<Vec3> scanner_;
  Vec3 u_, v_, w_;       ///< w towards the scanner.
  double distance_ = 1;  ///< Of the middle of the points from the scanner.
  double cell_;
  std::unordered_map<std::uint64_t, Depths> cells_;
};

/// Counts of what one scan's points are in the other's lines of sight.
struct SightCounts {
  int front = 0;
  int surface = 0;
  void add(const LinesOfSight& lines, std::span<const Vec3> points, const RigidTransform& lines_from_points,
           double tolerance, std::size_t stride);
};

}  // namespace patinate::capture
