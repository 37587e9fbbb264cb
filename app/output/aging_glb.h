/// \file
/// What a GLB of an aging mesh is made of: textures that are made while they are written, from strips of the atlas.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/device/checked_devices.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/history/history.h"
#include "patinate/output/glb.h"

namespace patinate::app {

/// What a model's file is made of.
struct ModelParts {
  Mesh mesh;
  GlbTiles tiles;
  GlbObjects objects;
  std::vector<GlbAppearance> appearance;  ///< By time.
};

struct AgingGlb {
  std::string key;          ///< Content key of all that its appearance depends on.
  HistoryManifest history;  ///< Its times.
  GlbTiles tiles;
  Mesh mesh;                ///< In mm, with UVs of every tile in the unit square.
  GlbObjects objects = {};  ///< Those of a simulation, where there are several.
  /// A look for each time, with normals and gloss where the history's frames have them. @param labels  Their names.
  std::function<std::vector<GlbAppearance>(const std::vector<double>& times, const std::vector<std::string>& labels,
                                           const RunControl& control)>
      appearance;
  /// Adds what formats with files of their own hold more: metalness and heights, where they are known. Empty: neither
  /// is.
  std::function<void(std::vector<GlbAppearance>& appearance, const std::vector<double>& times,
                     const RunControl& control)>
      add_relief = {};
  /// Takes lifted flakes off the surface, which gets the textures of what lies below them, and adds them in tiles of
  /// their own (add_flakes_to()). Empty: there are none.
  std::function<void(ModelParts& parts, const std::vector<double>& times, const std::vector<std::string>& labels,
                     bool are_objects, const RunControl& control)>
      add_flakes = {};
  double own_per_mm = 1.0;              ///< Lengths in the file that the mesh was read from: a transfer's are scaled.
  std::vector<std::string> notes = {};  ///< What is to be known of a model with a size.
};

/// @param path  A transfer or a simulation. @param devices  That compose.
/// @param has_flakes  Lifted flakes are geometry. @throws IoError
[[nodiscard]] AgingGlb open_aging_glb(const std::filesystem::path& path, const OutputDevices& devices = {},
                                      bool has_flakes = true);

}  // namespace patinate::app
