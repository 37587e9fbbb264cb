/// \file
/// Materials of a model as a MaterialX document [MaterialX Specification v1.38]: a standard_surface for each time and
/// tile, and a look for each time.
#pragma once

#include <string>
#include <vector>

#include "libcommon/output/model_textures.h"

namespace patinate {

struct MaterialXOptions {
  std::vector<std::string> time_names = {};  ///< One a time, "12.5 d".
  /// Geometry of a tile, as looks name it: "/bust/mesh". One a tile, or one for all.
  std::vector<std::string> geometries = {"/*"};
  double roughness = 0.8;  ///< Where no texture says it.
  std::string key = "";
  std::vector<std::string> credits = {};  ///< Whom the textures owe.
};

/// Base color, roughness, metalness, normal and displacement (in the mesh's unit) where there are files of them. The
/// first look is what programs show that do not choose.
/// @param tile_names  As GlbTiles::names.
[[nodiscard]] std::string materialx_text(const std::vector<std::string>& tile_names, const TextureFiles& files,
                                         const MaterialXOptions& options);

}  // namespace patinate
