/// \file
/// The text of a stage: meshes, materials, and textures over time.
#pragma once

#include <string>
#include <vector>

#include "libcommon/output/model_textures.h"
#include "patinate/geometry/mesh.h"
#include "patinate/output/usd.h"

namespace patinate {

/// @param mesh, tiles, times, options  As write_usd() takes them.
[[nodiscard]] std::string usd_text(const Mesh& mesh, const GlbTiles& tiles, const TextureFiles& files,
                                   const std::vector<double>& times, const UsdOptions& options);

/// Paths of what shows a tile, as looks name them: the meshes, or with several tiles every GeomSubset of the tile.
[[nodiscard]] std::vector<std::string> usd_geometries(const Mesh& mesh, const GlbTiles& tiles,
                                                      const UsdOptions& options);

}  // namespace patinate
