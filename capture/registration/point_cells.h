/// \file
/// Points sorted into cubic cells, for neighbors within a distance of about a cell.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate::capture {

/// Cells that hold points, in a hash table: memory follows the number of points, not the extent. Immutable; queries are
/// thread-safe.
class PointCells {
 public:
  /// @param points  Finite, less than 2^31 cells from the origin along each axis; must outlive this. @param cell  > 0.
  PointCells(std::span<const Vec3> points, double cell);

  /// Calls visit(index, squared distance) for every point within `radius` of p, in an order that depends on the points
  /// only.
  template <class Visit>
  void near(const Vec3& p, double radius, Visit&& visit) const {
    const Key low = key_of(p - Vec3::Constant(radius)), high = key_of(p + Vec3::Constant(radius));
    const double most = radius * radius;
    for (std::int64_t z = low[2]; z <= high[2]; ++z) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
          const int slot = find({x, y, z});
          if (slot < 0) continue;
          for (int k = begin_[slot]; k < begin_[static_cast<std::size_t>(slot) + 1]; ++k) {
            const double squared = (sorted_[k] - p).squaredNorm();
            if (squared <= most) visit(order_[k], squared);
          }
        }
      }
    }
  }
  struct Found {
    int index = -1;  ///< -1 = none.
    double squared_distance = 0.0;
  };
  /// The nearest point within `radius`; of several at the same distance the one with the smallest index.
  [[nodiscard]] Found nearest(const Vec3& p, double radius) const;
  [[nodiscard]] double cell() const { return cell_; }

 private:
  using Key = std::array<std::int64_t, 3>;
  [[nodiscard]] Key key_of(const Vec3& p) const {
    return {static_cast<std::int64_t>(std::floor(p.x() * per_cell_)),
            static_cast<std::int64_t>(std::floor(p.y() * per_cell_)),
            static_cast<std::int64_t>(std::floor(p.z() * per_cell_))};
  }
  [[nodiscard]] static std::uint64_t hash(const Key& key) {
    std::uint64_t h = static_cast<std::uint64_t>(key[0]) * 0x9E3779B97F4A7C15u ^
                      static_cast<std::uint64_t>(key[1]) * 0xC2B2AE3D27D4EB4Fu ^
                      static_cast<std::uint64_t>(key[2]) * 0x165667B19E3779F9u;
    return h ^ (h >> 29);
  }
  [[nodiscard]] int find(const Key& key) const {
    for (std::uint64_t at = hash(key) & mask_;; at = (at + 1) & mask_) {
      const int cell = table_[at];
      if (cell < 0 || keys_[cell] == key) return cell;
    }
  }

  double cell_;
  double per_cell_;
  std::uint64_t mask_ = 0;
  std::vector<int> table_;    ///< Slot -> cell, -1 = free.
  std::vector<Key> keys_;     ///< Keys of every cell.
  std::vector<int> begin_;    ///< Begin of every cell, in order_; one more at the end.
  std::vector<int> order_;    ///< Indices of points by cell.
  std::vector<Vec3> sorted_;  ///< The points in that order.
};

}  // namespace patinate::capture
