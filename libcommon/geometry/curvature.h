/// \file
/// Mean curvature of a mesh at a physical scale.
#pragma once

#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

/// Mean curvature at every position, concave positive (sphere with outward normals: -1/R, cylinder -1/(2R), plane 0).
///
/// The surface is smoothed by one implicit step of mean curvature flow, (M + t L) x' = M x with t = scale^2 / 2
/// [Desbrun et al. 1999; M: mixed Voronoi areas of Meyer et al. 2003], and H = (x' - x) . n / (2 t): features smaller
/// than `scale` average out, and irregular or coarse triangles do no harm. On a sphere the result is -(1/R) / (1 + 2 t
/// / R^2). Positions in no triangle get 0.
/// @param mesh      Edges should not be longer than scale / 2: see refine_edges().
/// @param scale_mm  Gaussian width that the step corresponds to; > 0; mesh in mm.
/// @throws InvalidInput if the scale is not positive or the mesh has no area.
[[nodiscard]] std::vector<double> mean_curvature(const Mesh& mesh, double scale_mm, const RunControl& control = {});

}  // namespace patinate
