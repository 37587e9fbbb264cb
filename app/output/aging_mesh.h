/// \file
/// A mesh that ages, wherever its color over time comes from: a transfer, or a simulation.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/device/checked_devices.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/sheet.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/history/history.h"
#include "patinate/image/image.h"
#include "patinate/output/render_surface.h"
#include "patinate/transfer/age.h"

namespace patinate::app {

inline constexpr double kWetFilm = 0.1;  ///< Amount of water that wets a place through.

struct AgingMesh {
  std::string key;          ///< Content key of all that its appearance depends on.
  HistoryManifest history;  ///< Its times.
  std::vector<std::string> tile_names;
  std::vector<int> triangle_tile;  ///< Empty when there is one tile.
  Mesh mesh;                       ///< In mm, with UVs over the sheet of all tiles.
  Mesh unit_mesh;                  ///< UVs of every tile in the unit square.
  /// Its texture over the sheet at a time: linear RGB, gutters filled.
  std::function<ImageF(double time, const RunControl& control)> sample;
  /// All maps of the surface, color included, over the sheet, from time `maps_from` on; heights are in the mesh's unit.
  /// Empty if there is only a color. Of a simulation with lifted flakes these are its pieces.
  std::function<SurfaceMaps(double time, const RunControl& control)> maps;
  bool may_have_flakes = false;                                 ///< Pieces of `maps` may be lifted flakes.
  bool is_reduced = false;                                      ///< `sample` shows means of several texels.
  double maps_from = -std::numeric_limits<double>::infinity();  ///< Of a simulation of an
                                                                ///< earlier version, its end.
};

/// @param path  A transfer or a simulation. @param devices  Devices that compose a simulation's maps.
/// @param film  Amount of water at which a place of a simulation is wet through.
/// @param relief  Factor by which heights below lifted flakes move a simulation's surface; nothing: flakes are heights.
/// @param most_texels  A transfer with more texels in all tiles has only a color, at a reduced size (ReducedTransfer).
/// @throws IoError
[[nodiscard]] AgingMesh open_aging_mesh(const std::filesystem::path& path, const OutputDevices& devices = {},
                                        double film = kWetFilm, std::optional<double> relief = {},
                                        std::int64_t most_texels = Sheet::kMaxTexels);
/// Mesh of a transfer in memory; one that was not read from a folder has no key.
[[nodiscard]] AgingMesh aging_mesh_of(const std::shared_ptr<const transfer::AgedMesh>& aged);

}  // namespace patinate::app
