/// \file
/// The nearest of many points (FLANN's exact k-d tree inside).
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Immutable after construction; queries are thread-safe. Exact; which of several points at the same distance is found
/// is not said.
class NearestPoints {
 public:
  /// @throws InvalidInput if there is no point.
  explicit NearestPoints(std::vector<Vec3> points);
  ~NearestPoints();
  NearestPoints(NearestPoints&&) noexcept;
  NearestPoints& operator=(NearestPoints&&) noexcept;

  struct Found {
    int index = -1;  ///< -1 = none.
    double distance = 0.0;
  };
  [[nodiscard]] Found nearest(const Vec3& p) const;
  /// The nearest of those that `counts` holds for and that are nearer than `below`.
  [[nodiscard]] Found nearest_of(const Vec3& p, double below, const std::function<bool(const Vec3&)>& counts) const;
  struct Nearest {
    int index = -1;  ///< -1 = none.
    double squared_distance = 0.0;
    double squared_second = 0.0;  ///< To the next one, or the square of `below` where that is less.
  };
  /// The nearest that is nearer than `below`, of several at the same distance the one with the smallest index.
  /// @param hint  A point that is likely near, or -1: makes it faster, never another.
  [[nodiscard]] Nearest nearest_below(const Vec3& p, double below, int hint = -1) const;
  [[nodiscard]] const Vec3& point(int index) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace patinate
