/// \file
/// Aging meshes as USD [openusd.org, "UsdPreviewSurface Specification"; "USDZ File Format Specification"].
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/output/glb.h"

namespace patinate {

struct UsdOptions {
  std::string name = "object";     ///< Of the root.
  double meters_per_unit = 0.001;  ///< > 0. 0.001 for a mesh in mm.
  std::string time_unit = "s";     ///< Of the times, for people: time codes are these numbers.
  double duration_s = 10.0;        ///< From first to last time when it is played; > 0.
  double roughness = 0.8;          ///< [0, 1], where no texture says it.
  std::string key = "";            ///< Content key, kept in customLayerData.
  GlbObjects objects = {};
  std::vector<std::string> credits = {};  ///< Whom the textures owe; kept in customLayerData.
};

/// A stage with a mesh for each object, which is visible at one time alone where all of its tiles are, and a
/// UsdPreviewSurface for each tile, whose textures have a time sample at every time. `.usdz`: one file. `.usda`: text,
/// and its textures as PNG in `STEM.textures` beside it, which is replaced first. Axes are kept, +Y up; v is up as in
/// the mesh. Equal input gives equal bytes; no dates.
/// @param appearance  One a time: base_colors (sRGB), normals and speculars (stored as they are: roughness = 1 -
/// value).
/// @param times  Strictly increasing, as many.
/// @throws InvalidInput if the mesh has no UVs, lists differ in length, or there is no time; ParseError on another
/// extension; CannotComplete if it cannot be written, or a .usdz would hold more than 4 GiB. Memory: the mesh, and a
/// texture while it is made.
void write_usd(const std::filesystem::path& path, const Mesh& mesh, const GlbTiles& tiles,
               const std::vector<GlbAppearance>& appearance, const std::vector<double>& times,
               const UsdOptions& options = {}, const RunControl& control = {});

/// The content key in a file that write_usd() made; "" if it carries none. @throws IoError if it cannot be read.
[[nodiscard]] std::string read_usd_key(const std::filesystem::path& path);

}  // namespace patinate
