/// \file
/// Where on the reference scan a change of height is asked for: one place a pixel of a parallel view.
#pragma once

#include <span>
#include <vector>

#include "capture/relief/height_probe.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/point_cloud.h"

namespace patinate::capture {

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
  int x = 0, y = 0;       ///< Of the view.
  Vec3 position, normal;  ///< In the scan's frame; the normal on the viewer's side.
  double area = 0.0;      ///< Of the surface within the pixel.
};

/// The topmost surface that the view sees, where a plane through the points within `radius` is one; by rows.
[[nodiscard]] std::vector<ReliefPlace> relief_places(std::span<const Vec3> points, const HeightProbe& probe,
                                                     const ReliefView& view, double radius, const RunControl& control);

}  // namespace patinate::capture
