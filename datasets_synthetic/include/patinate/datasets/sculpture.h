/// \file
/// A procedural sculptural mesh with concavities and an atlas by construction: a lidded urn with handles.
#pragma once

#include "patinate/core/options.h"
#include "patinate/geometry/mesh.h"

namespace patinate::datasets {

/// Settings of sculpture().
struct SculptureOptions {
  double height_mm = 200.0;    ///< > 0.
  int resolution = 76;         ///< Height over the length of an edge; [24, 400]. Triangles grow with its square.
  int num_flutes = 20;         ///< Around the lower belly; [0, 60].
  double flute_depth = 0.040;  ///< In radii of the belly; [0, 0.08].
  double relief = 0.032;       ///< Height of the carved band, in radii of the belly; [0, 0.06].
  double twist_deg = 28.0;     ///< By how much the flutes wind; [-90, 90].
};

void describe(OptionVisitor& v, SculptureOptions& o);

/// A mesh in mm, y up, standing on y = 0: an urn (surface of revolution with flutes and a carved band) with foot, lid
/// and finial, and two handles that enter its body. The three parts are closed and consistently oriented; normals are
/// per vertex. UVs are 16 charts, rectangles along the profile and the handles, discs at ends; they do not overlap and
/// are not mirrored. The length on the surface that a texel shows, the longest and the shortest direction of every
/// triangle taken together, differs by less than a factor of 3 between the 1st and the 99th percentile, and by less
/// than 6 between extremes. About 60 000 triangles at the defaults. No random choices.
/// @throws InvalidInput
[[nodiscard]] Mesh sculpture(const SculptureOptions& options = {});

}  // namespace patinate::datasets
