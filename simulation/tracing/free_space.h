/// \file
/// How far one can fly from a place in any direction without meeting a triangle.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/tracing/ray_tracer.h"

namespace patinate::simulation {

/// A grid over a scene's box, at most 64 cells along its longest side; each cell knows how many cells around it are
/// empty.
class FreeSpace {
 public:
  explicit FreeSpace(const RayTracer& rays);

  /// Nothing lies nearer to `p` than this along any axis (in the maximum norm), mm; 0 where something may. Outside of
  /// the grid: 0.
  [[nodiscard]] double distance(const Vec3& p) const {
    const Vec3 at = (p - low_) * inverse_cell_;
    if (!(at.x() >= 0.0 && at.y() >= 0.0 && at.z() >= 0.0 && at.x() < size_[0] && at.y() < size_[1] &&
          at.z() < size_[2]))
      return 0.0;
    const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y()), z = static_cast<int>(at.z());
    return empty_[static_cast<std::size_t>((z * size_[1] + y) * size_[0] + x)] * cell_;
  }
  [[nodiscard]] double cell_mm() const { return cell_; }

 private:
  Vec3 low_ = Vec3::Zero();
  double cell_ = 1.0, inverse_cell_ = 1.0;
  std::array<int, 3> size_{0, 0, 0};
  std::vector<std::uint8_t> empty_;  ///< Cells that are empty on all sides of this one, less than 256.
};

}  // namespace patinate::simulation
