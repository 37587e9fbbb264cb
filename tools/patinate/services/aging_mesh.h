/// \file
/// A mesh that ages, wherever its color over time comes from: a transfer, or a simulation.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/sheet.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/history/history.h"
#include "patinate/image/image.h"
#include "patinate/output/render.h"

namespace patinate::cli {

struct AgingMesh {
  std::string key;          ///< Content key of all that its appearance depends on.
  HistoryManifest history;  ///< Its times.
  std::vector<std::string> tile_names;
  std::vector<int> triangle_tile;  ///< Empty when there is one tile.
  Mesh mesh;                       ///< UVs over the sheet of all tiles.
  Mesh unit_mesh;                  ///< UVs of every tile in the unit square.
  double meters_per_unit = 0.001;
  /// Its texture over the sheet at a time: linear RGB, gutters filled.
  std::function<ImageF(double time, const RunControl& control)> sample;
  /// What its history's frames say of relief and gloss at a time, over the sheet; nothing when they say nothing.
  std::function<SurfaceDetail(double time, const RunControl& control)> detail;
};

/// @param path  A transfer or a simulation. @throws IoError
[[nodiscard]] AgingMesh open_aging_mesh(const std::filesystem::path& path);

}  // namespace patinate::cli
