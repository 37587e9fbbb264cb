/// \file
/// A procedural sculptural mesh with concavities and an atlas by construction: a lidded urn with handles.
#pragma once

#include "libcommon/core/options.h"
#include "libcommon/geometry/mesh.h"

namespace patinate {

/// Settings of sculpture().
struct SculptureOptions {
  double height_mm = 200.0;     ///< > 0.
  int segments = 240;           ///< Around the axis, a multiple of 4; [48, 1920]. Triangles grow with its square.
  int num_flutes = 20;          ///< Around the lower belly; [0, 60].
  double flute_depth = 0.035;   ///< In radii of the belly; [0, 0.1].
  double relief = 0.030;        ///< Height of the carved band, in radii of the belly; [0, 0.1].
  double twist_deg = 40.0;      ///< By how much the flutes wind; [-180, 180].
};

void describe(OptionVisitor& v, SculptureOptions& o);

/// A closed, consistently oriented mesh in mm, y up, standing on y = 0: an urn (surface of revolution with flutes and a
/// carved band) with foot, lid and finial, and two handles that enter its body. Normals are per vertex.
/// UVs are rectangles, one per part of the profile, one per handle half, discs for the ends; they do not overlap, and the
/// size of a texel on the surface differs by less than a factor of 3 in any direction between any two places.
/// About 50 000 triangles at the defaults. No random choices.
/// @throws InvalidInput
[[nodiscard]] Mesh sculpture(const SculptureOptions& options = {});

}  // namespace patinate
