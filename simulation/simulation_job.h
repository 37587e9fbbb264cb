/// \file
/// A simulation as a job: killed, it goes on from its last checkpoint; the folder is whole or absent.
#pragma once

#include <filesystem>

#include "libcommon/job/job.h"
#include "simulation/engine.h"
#include "simulation/scene/scene_io.h"

namespace patinate {

/// The folder of formats.md: simulation.json, atlas.exr, color.png, normal.png, height.exr, specular.png, model.glb, controls/, history/.
/// Items are stretches of iterations that end at frames of the history (and after 200 iterations at the latest); what is done in one
/// lies in a checkpoint, so that a killed run loses at most one stretch.
[[nodiscard]] JobPlan plan_simulation(SceneFile scene, const SimulationOptions& options, const std::filesystem::path& output);

/// What `simulation.json` says about a finished folder.
struct SimulationManifest {
  std::string name;
  std::filesystem::path scene;  ///< The scene file.
  std::int64_t iterations = 0;
  double time = 0.0;
  std::string time_unit;
  std::vector<std::string> materials;
  int resolution = 0;
  ColorForm color_form = ColorForm::Normalised;
  std::vector<std::string> controls;
  std::string key;
};
/// @param path  A simulation folder, or its simulation.json. @throws IoError
[[nodiscard]] SimulationManifest read_simulation_manifest(const std::filesystem::path& path);

}  // namespace patinate
