/// \file
/// Normals of meshes that have none, smooth where a round surface is meant and hard where it is not.
#pragma once

#include "patinate/geometry/mesh.h"

namespace patinate {

/// Edges that bend by more than this, in degrees, are hard unless something else is said: a turn of nine facets (40
/// degrees each) or more is meant round; chamfers of 45 degrees and the edges of boxes are not.
inline constexpr double kCreaseDeg = 40.0;

/// Shading normals per corner: the file's where it has them; else those of the triangles around a corner which are
/// joined by edges that bend by at most `crease_deg`, weighted by angle [Thuermer and Wuthrich 1998]. A triangle
/// without area is joined to all beside it.
/// @param crease_deg  [0, 180]. Cost: 0.5 us a triangle.
[[nodiscard]] Mesh with_crease_normals(Mesh mesh, double crease_deg = kCreaseDeg);

}  // namespace patinate
