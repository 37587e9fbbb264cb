#include "simulation/job/reopened_simulation.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/job/job_record.h"
#include "patinate/core/error.h"
#include "simulation/job/simulation_job.h"
#include "simulation/job/simulation_output.h"

namespace patinate::simulation {

namespace {

/// Where the folder's record does not tell, it counts as changed.
bool is_changed_by_hand(const std::filesystem::path& folder, const std::string& key) {
  const JobRecord record = read_job_record(folder, key);
  return record.key.empty() || std::any_of(record.depends_on.begin(), record.depends_on.end(),
                                           [](const JobDependency& d) { return d.name == kChangedByHand; });
}

}  // namespace

ReopenedSimulation reopen_simulation(const std::filesystem::path& path, std::shared_ptr<const SimulationDevice> device,
                                     const RunControl& control) {
  const std::filesystem::path folder = manifest_folder(path, "simulation.json");
  const SimulationManifest manifest = read_simulation_manifest(folder);
  SceneFile file = read_scene(manifest.scene, control.part(0.0, 0.4));
  if (const std::string changed = changed_inputs(folder, file); !changed.empty())
    throw IoError(path.string(), "is not as it was made, so that it cannot go on: " + changed + " has changed");
  const std::int64_t iterations = file.iterations;
  manifest.apply_to(file);
  file.iterations = iterations;  // Of the whole run.
  std::vector<std::string> maps;
  for (const SimulatedControl& control_map : manifest.controls) maps.push_back(control_map.name);
  SimulationOptions options{
      .parameter_maps = std::move(maps), .color_form = manifest.color_form, .device = std::move(device)};
  Simulation simulation(file.scene, options, control.part(0.4, 0.9));
  if (!read_state_file(folder, simulation))
    throw IoError(path.string(), "holds no state.bin, from which it would go on; `simulate` and save() write one");
  const bool by_hand = is_changed_by_hand(folder, manifest.key);
  return {std::move(file), std::move(options), std::move(simulation), by_hand};
}

}  // namespace patinate::simulation
