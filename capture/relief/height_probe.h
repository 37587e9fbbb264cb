/// \file
/// How high a scanned surface stands over a place, along a direction: the plane through the points around it.
#pragma once

#include <optional>
#include <span>

#include "capture/registration/point_cells.h"
#include "patinate/geometry/mesh.h"

namespace patinate::capture {

/// A surface over a place.
struct LocalHeight {
  double height = 0.0;    ///< Along the direction, from the place.
  double variance = 0.0;  ///< Of it, from what the points leave of the plane; > 0.
  Vec3 normal;            ///< Of the plane, unit, on the side that the direction points to.
  int num_points = 0;
};

/// Answers for one scan, in its own frame and unit. Immutable; queries are thread-safe and give the same bits whatever
/// else was asked.
class HeightProbe {
 public:
  /// @param points  Finite; must outlive this. @param radius  Of the cylinder whose points count, > 0.
  /// @param reach   How far along the direction a surface is looked for, on either side; >= radius.
  HeightProbe(std::span<const Vec3> points, double radius, double reach);

  /// The layer nearest to the place, where there are several. Points off the plane by more than 3.5 robust standard
  /// deviations do not count. The plane is fitted in the two coordinates across the direction, so that slopes that two
  /// scans share cancel in the difference of their heights [Lague, Brodu, Leroux 2013, M3C2, there without slopes].
  /// @param direction  Unit.
  /// @returns nothing where fewer than 10 points are, or they lie to one side (the scan ends), or stand as a wall.
  [[nodiscard]] std::optional<LocalHeight> over(const Vec3& place, const Vec3& direction) const;

 private:
  std::span<const Vec3> points_;
  double radius_, reach_;
  PointCells cells_;
};

}  // namespace patinate::capture
