/// \file
/// All that a finished simulation says of its surface.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "patinate/core/run_control.h"
#include "patinate/history/history.h"
#include "patinate/output/render_surface.h"
#include "patinate/simulation/engine.h"

namespace patinate::app {

/// A finished simulation, composed again at any of its times. Water is a film, not a color: color, gloss and height are
/// those of the dry surface, composed without it. Metal is what the presets say is bare metal and nothing covers.
/// Heights are mm. Not thread-safe.
class SimulatedSurface {
 public:
  /// @param folder  That `simulate` made. @param film  Amount of water that wets a place through; > 0.
  /// @param device  Composes; may be null. @throws IoError also if the scene in the folder is no longer the one that
  /// was run.
  SimulatedSurface(const std::filesystem::path& folder, double film,
                   std::shared_ptr<const simulation::SimulationDevice> device, const RunControl& control);

  /// Whether frames have their amounts; simulations of earlier versions know those of the end alone.
  [[nodiscard]] bool has_course() const { return has_course_; }
  /// Over the atlas, gutters filled. Between two frames the amounts are blended. @param time  In the scene's unit.
  /// @throws IoError
  [[nodiscard]] SurfaceMaps at(double time, const RunControl& control);

 private:
  std::filesystem::path folder_;
  double film_;
  bool has_course_ = false;
  HistoryManifest frames_;
  std::unique_ptr<simulation::Simulation> simulation_;
};

}  // namespace patinate::app
