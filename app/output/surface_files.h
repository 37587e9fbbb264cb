/// \file
/// A mesh with maps of its surface as image files.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "libcommon/core/hash.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/output/render_surface.h"

namespace patinate::app {

/// Files of a surface's maps; with UDIM tiles or several materials one each (tile_map_files()).
struct SurfaceFiles {
  /// One of the files.
  struct Named {
    const char* name;  ///< "normal-map".
    const char* help;
    std::filesystem::path SurfaceFiles::*file;
  };
  std::filesystem::path color;
  std::filesystem::path normal, roughness, metalness, specular, height, wetness;

  /// Names and files: texture, normal-map, roughness-map, ...
  [[nodiscard]] static std::span<const Named> named();
  /// Whether there is more than color.
  [[nodiscard]] bool has_more() const;
  /// Adds names and contents. @throws IoError
  void add_to(ContentHash& hash, const AtlasMesh& atlas) const;
};

/// The textures of all tiles in one sheet, gutters filled: what lies beside the charts must not bleed into them.
/// @param mesh_over_sheet  Gets the mesh with UVs over the sheet.
[[nodiscard]] ImageF sheet_texture(const AtlasMesh& atlas, std::vector<ImageF> textures, Mesh& mesh_over_sheet);
/// The color alone. @throws IoError
[[nodiscard]] ImageF read_color_map(const AtlasMesh& atlas, const SurfaceFiles& files, Mesh& mesh_over_sheet);
/// All maps. Heights are divided by `mm_per_unit`. Normals of 8 and 16 bit are codes of [-1, 1], as in glTF; others are
/// vectors. @throws IoError
[[nodiscard]] SurfaceMaps read_surface_maps(const AtlasMesh& atlas, const SurfaceFiles& files, double mm_per_unit,
                                            Mesh& mesh_over_sheet);

}  // namespace patinate::app
