/// \file
/// Which mesh is asked for, which of its surfaces, its unit and its atlas.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "app/request/unit_argument.h"
#include "app/request/words.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"

namespace patinate::app {

struct MeshSource {
  std::filesystem::path path;
  std::string unit;      ///< "" = not said.
  std::string node;      ///< "" = all.
  std::string material;  ///< "" = all.
  /// Stated unit; "m" for glTF. @throws UsageError if the unit is none.
  [[nodiscard]] std::optional<std::string> unit_or_none() const;
};

/// The chosen surfaces, repaired (a note says what), with normals, in the file's unit. @throws IoError
[[nodiscard]] Mesh load_mesh(const MeshSource& source, const Words& say);

/// Range of --resolution.
[[nodiscard]] Range resolution_range();

struct AtlasOptions {
  int resolution = 1024;  ///< Texels along each side of a tile; [16, 16384].
  AtlasMethod method = AtlasMethod::Auto;
};
void describe(OptionVisitor& v, AtlasOptions& o);

/// make_atlas_mesh(); errors in the mesh name its file.
[[nodiscard]] AtlasMesh make_atlas(const MeshSource& source, Mesh mesh, const AtlasOptions& options,
                                   const RunControl& control);
/// Says what a user should know of the atlas.
void note_atlas(const MeshSource& source, const AtlasMesh& atlas, const Words& say);
/// make_texel_map(); errors name the file.
[[nodiscard]] TexelMap make_texel_map(const MeshSource& source, const AtlasMesh& atlas, int resolution,
                                      const RunControl& control);

}  // namespace patinate::app
