/// \file
/// The text of a stage: meshes, materials, and textures over time.
#pragma once

#include <string>
#include <vector>

#include "patinate/geometry/mesh.h"
#include "patinate/output/usd.h"

namespace patinate {

/// Files of the textures, relative to the stage: [time][tile]; normals and speculars may be empty.
struct UsdTextureFiles {
  std::vector<std::vector<std::string>> base_colors, normals, speculars;
};

/// @param mesh, tiles, times, options  As write_usd() takes them.
[[nodiscard]] std::string usd_text(const Mesh& mesh, const GlbTiles& tiles, const UsdTextureFiles& files,
                                   const std::vector<double>& times, const UsdOptions& options);

}  // namespace patinate
