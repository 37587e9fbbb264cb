/// \file
/// Where on the reference scan a change of height is asked for: one place a pixel of a parallel view.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "capture/registration/point_cells.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/geometry/point_cloud.h"

namespace patinate::capture {

/// A surface over a place.
struct LocalHeight {
  double height = 0.0;    ///< Along the direction, from the place.
  double variance = 0.0;  ///< Variance of the height, from what the points leave of the plane; > 0.
  Vec3 normal;            ///< Normal of the plane, unit, on the side that the direction points to.
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

/// A parallel view of a surface. Rows go down, columns to the right.
struct ReliefView {
  Vec3 right, up, toward;  ///< Orthonormal; `toward` the viewer.
  Vec3 corner;             ///< Center of the top left pixel, at depth 0.
  double texel = 0.0;
  int width = 0;
  int height = 0;
  bool is_side_known = true;  ///< false: nothing says which side of the surface is outside; +z was taken.

  [[nodiscard]] Vec3 at(int x, int y) const { return corner + texel * (x * right - y * up); }
};

/// @param toward  Not 0: the side that is seen. 0: across the plane that fits the points best, on the side of the
/// scanner, of the file's normals or of its triangles, and else of +z.
/// @param margin  Around what the scan covers; < 0 leaves its border out.
/// @throws InvalidInput if the view would have more than 65536 pixels along a side, or none.
[[nodiscard]] ReliefView relief_view(const PointCloud& scan, const Vec3& toward, double texel, double margin);

struct ReliefPlace {
  int x = 0, y = 0;       ///< Pixel of the view.
  Vec3 position, normal;  ///< In the scan's frame; the normal on the viewer's side.
  double area = 0.0;      ///< Area of the surface within the pixel.
};

/// The topmost surface that the view sees, where a plane through the points within `radius` is one; by rows.
[[nodiscard]] std::vector<ReliefPlace> relief_places(std::span<const Vec3> points, const HeightProbe& probe,
                                                     const ReliefView& view, double radius, const RunControl& control);

}  // namespace patinate::capture
