/// \file
/// UVs for a mesh that has none: charts within normal cones, flattened by least squares conformal maps, packed on one
/// square.
#pragma once

#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

/// Settings of unwrap().
struct UnwrapOptions {
  double max_normal_angle_deg =
      60.0;                  ///< [5, 85]. Half opening of the cone that a chart's normals keep to while it grows.
  double max_stretch = 1.5;  ///< [1.05, 10]. Charts are cut until 95 % of their area is stretched by no more than this.
  int resolution = 1024;     ///< [16, 16384]. Texels along each side of the atlas that the UVs are packed for.
  int gutter_texels = 2;     ///< [1, 64]. Least number of texels between two charts.
};
void describe(OptionVisitor& v, UnwrapOptions& o);

/// A figure over all triangles with an area, weighted by it.
struct StretchFigure {
  double median = 1.0;
  double p95 = 1.0;
  double max = 1.0;
};

/// What unwrap() made. s1 >= s2 are the singular values of a triangle's map from the surface to the atlas, in units of
/// the whole atlas's scale sqrt(area in the atlas / area of the surface): 1 and 1 where lengths are kept.
struct UnwrapResult {
  Mesh mesh;  ///< The input with uvs and uv_triangles, all in [0, 1] and counter-clockwise; all else unchanged.
  std::vector<int> triangle_chart;  ///< As long as triangles; from 0, largest chart first.
  int num_charts = 0;
  int num_planar_charts = 0;     ///< Charts that no conformal map suited: projected along their mean normal.
  int num_degenerate = 0;        ///< Triangles without an area; slivers or points of the atlas.
  double packing = 0.0;          ///< Share of the atlas that charts cover, [0, 1].
  double texels_per_unit = 0.0;  ///< Mean texel density: texels of `resolution` along one mesh unit.
  StretchFigure stretch;         ///< max(s1, 1 / s2) >= 1: the worst change of a length.
  StretchFigure angle_stretch;   ///< s1 / s2 >= 1: 1 where angles are kept.
  StretchFigure area_stretch;    ///< max(s1 s2, 1 / (s1 s2)) >= 1: the change of texel density.
  double l2_stretch = 1.0;       ///< Root mean square of 1 / s over directions and area; >= 1 [Sander et al. 2001].
};

/// Cuts the surface into charts and lays them flat without flips or overlaps: every texel shows one point of the
/// surface.
///
/// Charts grow from seeds by cost of path [Sander et al. 2003, sec. 3.1] within normal cones, borders are pulled to
/// creases and straightened, what is no disc is cut, charts are flattened by least squares conformal maps [Levy et al.
/// 2002], those that flip, overlap or stretch too much are cut again, small ones merged, and all packed as bitmaps at
/// one texel density. Existing UVs are ignored. Edges of more than two triangles, or of two with opposite windings, are
/// borders of charts. Depends only on shape: a moved, turned or scaled mesh gets the same UVs up to rounding. Units of
/// the mesh do not matter.
/// @throws InvalidInput if the mesh has no triangles or no area, a position is not finite, an option is out of range,
/// or it
///     has more separate pieces than the atlas has room for.
/// @throws Canceled
/// Cost: about 25 microseconds per triangle on one core, and half a second of packing. Same bits for any number of
/// threads.
[[nodiscard]] UnwrapResult unwrap(const Mesh& mesh, const UnwrapOptions& options = {}, const RunControl& control = {});

}  // namespace patinate
