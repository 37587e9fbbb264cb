/// \file
/// The mesh that a transfer ages: its atlas, its size in mm, and how many texels it gets.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/mesh/mesh_source.h"
#include "app/request/words.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/geometry/mesh.h"
#include "transfer/guidance/scale.h"

namespace patinate::app {

struct Destination {
  std::shared_ptr<const AtlasMesh> atlas;  ///< In mm.
  std::shared_ptr<const TexelMap> map;     ///< Map of the same mesh.
  std::optional<std::string> unit;         ///< Unit of the mesh file, when it is known.
  double mm_per_mesh_unit = 1.0;
  double texel_size_mm = 1.0;  ///< Surface length of one pixel of the history.
};

/// Says which sizes were chosen, not known. @param mesh  In mm. @param unit_option  What sets the mesh's unit.
void note_scale(const transfer::TransferScale& scale, const Mesh& mesh, const std::string& unit_option,
                const Words& say);
/// Says when texels and the history's pixels differ so much that texture is left out or magnified.
/// @param pixel_mm  Surface length of one pixel of the history.
void note_texels(const TexelMap& map, double pixel_mm, bool is_unwrapped, const Words& say);

/// Reads the mesh and chooses what was not said: without a unit it is scaled so that a texel equals a pixel of the
/// history; with one, and a history that knows its texel size, every tile gets as many texels as it takes to show every
/// pixel (256 along a side at least, and in all tiles together no more than 4096 x 4096) unless --resolution was given.
/// Notes say what was chosen.
/// @param pixel_mm  Surface length of one pixel of the history, when it is known.
/// @throws IoError naming the mesh's file.
[[nodiscard]] Destination make_destination(const MeshSource& source, const AtlasOptions& options,
                                           bool is_resolution_given, std::optional<double> pixel_mm, const Words& say);

}  // namespace patinate::app
