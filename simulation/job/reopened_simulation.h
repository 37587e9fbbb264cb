/// \file
/// A simulation's folder as a simulation that goes on.
#pragma once

#include <filesystem>
#include <memory>

#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"

namespace patinate::simulation {

struct ReopenedSimulation {
  SceneFile file;                   ///< The folder's own scene, with the resolution and seed that were used.
  SimulationOptions options;        ///< With the parameter maps and the color form of the folder.
  Simulation simulation;            ///< In the folder's last state.
  bool is_changed_by_hand = false;  ///< By more than its steps.
};

/// Steps from here on give the bytes of a run that was never interrupted.
/// @param path  The folder, or its simulation.json. @param device  May be null.
/// @throws IoError if the folder holds no state (it was recomposed, or made by an earlier version), or its scene is
/// not as it was written.
[[nodiscard]] ReopenedSimulation reopen_simulation(const std::filesystem::path& path,
                                                   std::shared_ptr<const SimulationDevice> device,
                                                   const RunControl& control = {});

}  // namespace patinate::simulation
