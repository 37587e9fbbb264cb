/// \file
/// A mesh at one time as OBJ, with its material as MTL and MaterialX.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/output/glb.h"

namespace patinate {

struct ObjOptions {
  std::string name = "object";  ///< Of the object, where there is one.
  double roughness = 0.8;       ///< [0, 1], where no texture says it.
  std::string key = "";         ///< Content key, kept in the OBJ's first line.
  GlbObjects objects = {};
  std::vector<std::string> credits = {};  ///< Whom the textures owe: comments of the MTL, `doc` of the MaterialX.
};

/// Writes `STEM.obj` (an `o` for each object, a `usemtl` for each tile), and beside it `STEM.mtl` (`map_Kd`, and where
/// they are known `map_Pr`, `map_Pm`, `norm` and `disp`), `STEM.obj.mtlx` with the same, and `STEM.obj.textures`,
/// which is replaced first; a stage of the same name has others. Numbers are the mesh's own, in its unit. Equal input
/// gives equal bytes; no dates.
/// @param appearance  At the time that is shown; its name is that of the MaterialX look.
/// @throws InvalidInput if the mesh has no UVs or lists differ in length; CannotComplete if it cannot be written.
void write_obj_model(const std::filesystem::path& path, const Mesh& mesh, const GlbTiles& tiles,
                     const GlbAppearance& appearance, const ObjOptions& options = {}, const RunControl& control = {});

}  // namespace patinate
