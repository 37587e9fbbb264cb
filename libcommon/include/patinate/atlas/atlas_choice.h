/// \file
/// Makes any mesh ready for texels: its own UVs where every place has a texel of its own, else unwrapped.
#pragma once

#include <array>
#include <string_view>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/core/run_control.h"

namespace patinate {

enum class AtlasMethod {
  Auto,   ///< The mesh's UVs, unless find_uv_layout() has a problem with them.
  Uv,     ///< The mesh's UVs: places that share texels age alike.
  Unwrap  ///< New UVs by unwrap().
};
inline constexpr std::array<std::string_view, 3> kAtlasMethodNames{"auto", "uv", "unwrap"};

/// @param resolution  Texels along a tile: an unwrapped atlas keeps its gutters for it.
/// @throws InvalidInput for Uv when the mesh has no UVs, or UVs outside [0, 1] that are no tiles; what unwrap() throws.
[[nodiscard]] AtlasMesh make_atlas_mesh(Mesh mesh, AtlasMethod method, int resolution, const RunControl& control = {});

}  // namespace patinate
