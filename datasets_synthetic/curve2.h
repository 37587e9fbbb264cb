/// \file
/// A smooth plane curve through points, by arc length; for profiles and paths of synthetic shapes.
#pragma once

#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate::datasets {

/// Centripetal Catmull-Rom curve [Yuksel, Schaefer, Keyser 2011], resampled by arc length.
class Curve2 {
 public:
  /// @param points  At least two, neighbors different.
  explicit Curve2(const std::vector<Vec2>& points);

  [[nodiscard]] double length() const { return lengths_.back(); }
  /// Arc length at control point `index`.
  [[nodiscard]] double length_at(int index) const { return lengths_[static_cast<std::size_t>(index) * kSteps]; }
  /// s is clamped to [0, length()].
  [[nodiscard]] Vec2 at(double s) const;
  /// Unit.
  [[nodiscard]] Vec2 tangent(double s) const;

 private:
  static constexpr std::size_t kSteps = 64;  // Between two control points.
  std::vector<Vec2> samples_;
  std::vector<double> lengths_;
};

}  // namespace patinate::datasets
