/// \file
/// Steps of unwrap(), 3: one chart laid flat [Levy, Petitjean, Ray, Maillot 2002, "Least squares conformal maps"].
#pragma once

#include <array>
#include <vector>

#include "libcommon/atlas/unwrap_surface.h"

namespace patinate {

enum class FlatStatus {
  Good,
  Closed,       ///< Has no border.
  Flipped,      ///< A triangle came out clockwise, or a fan wound twice around its middle.
  Overlapping,  ///< Borders cross.
  Stretched,    ///< 95 % of the area needs more than the stretch allowed.
};

struct FlatChart {
  std::vector<int> triangles;     ///< Triangles of the surface, ascending.
  std::vector<Triangle> corners;  ///< Into points; as long as triangles.
  std::vector<Vec2> points;       ///< The chart's area is that on the surface.
  FlatStatus status = FlatStatus::Good;
  bool is_planar = false;  ///< Projected along its mean normal, since the conformal map was not Good.
};

/// Lays a set of triangles, connected over edges, in the plane. When Good, no two triangles overlap: all are
/// counter-clockwise, all fans wind once, and the borders (any number of them) neither meet themselves nor each other,
/// which for a connected piece leaves no point of the plane covered twice. Not Good: points are there but not to be
/// used. Cost: one sparse factorization; about 10 microseconds per triangle.
[[nodiscard]] FlatChart flatten_chart(const UnwrapSurface& surface, std::vector<int> triangles, double max_stretch);

/// Singular values, larger first, of the linear map that takes triangle `from` to `to`.
[[nodiscard]] std::array<double, 2> singular_values(const std::array<Vec2, 3>& from, const std::array<Vec2, 3>& to);

/// Value that `share` of the weight does not exceed; 1 if there is none. Sorts.
[[nodiscard]] double weighted_quantile(std::vector<std::pair<double, double>>& value_and_weight, double share);

}  // namespace patinate
