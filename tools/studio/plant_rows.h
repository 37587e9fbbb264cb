/// \file
/// Where small plants can grow, for the browser: it shows those for which there is enough.
#pragma once

#include <string>

#include "tools/studio/mesh_glb.h"

namespace patinate::studio {

/// Numbers of a place in plant_rows().
inline constexpr int kPlantRow = 17;

/// The places of plants as `render` has them, y up. By place float32: number of its part, kind, root x, y, z and
/// upward direction x, y, z in the mesh's unit, u, v (down), height when full-grown, turn in radians, amount from which
/// on it shows, share of the color of what it grows on, own color R, G, B (linear).
/// @param mesh  With UVs; as it was given, not refined.
[[nodiscard]] std::string plant_rows(const PartedMesh& mesh);

}  // namespace patinate::studio
