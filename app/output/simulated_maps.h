/// \file
/// All that a finished simulation says of its surface.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/history/history.h"
#include "patinate/output/render_surface.h"
#include "patinate/simulation/engine.h"

namespace patinate::app {

/// Where the surface of a simulation lies, for flakes that stand off it.
struct FlakeGround {
  std::shared_ptr<const Mesh> mesh;  ///< mm, with UVs over the atlas and normals. Null: flakes are heights alone.
  double relief = 1.0;               ///< Factor of heights below flakes (maps_and_flakes()).
};

/// Whether the texels of a simulation's frames may be lifted flakes: they say where a layer has cracks.
[[nodiscard]] bool may_have_flakes(const std::filesystem::path& history, const HistoryManifest& frames);

/// A finished simulation, composed again at any of its times. Metal is what the presets say is bare metal and nothing
/// covers. Heights are mm. Not thread-safe.
class SimulatedSurface {
 public:
  /// @param folder  That `simulate` made.
  /// @param film    Amount of water that wets a place through, > 0: water is a film then, not a color, and color, gloss
  ///                and height are those of the dry surface. Nothing: water has the look that the scene gives it.
  /// @param device  Composes; may be null. @throws IoError also if the scene in the folder is no longer the one that
  /// was run.
  SimulatedSurface(const std::filesystem::path& folder, std::optional<double> film,
                   std::shared_ptr<const simulation::SimulationDevice> device, FlakeGround flakes,
                   const RunControl& control);

  /// Whether frames have their amounts; simulations of earlier versions know those of the end alone.
  [[nodiscard]] bool has_course() const { return has_course_; }
  /// Over the atlas, gutters filled; their pieces are lifted flakes, if the ground of these is known. Between two
  /// frames the amounts are blended. @param time  In the scene's unit. @throws IoError
  [[nodiscard]] SurfaceMaps at(double time, const RunControl& control);

 private:
  [[nodiscard]] SurfaceMaps composed(const RunControl& control);

  std::filesystem::path folder_;
  std::optional<double> film_;
  FlakeGround flakes_;
  std::optional<TexelMap> map_;  ///< Of flakes_.mesh, once there are flakes.
  bool has_course_ = false;
  HistoryManifest frames_;
  std::unique_ptr<simulation::Simulation> simulation_;
};

}  // namespace patinate::app
