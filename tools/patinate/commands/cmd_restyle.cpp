#include <memory>
#include <utility>

#include "app/device/checked_devices.h"
#include "app/request/usage_error.h"
#include "patinate/core/error.h"
#include "simulation/job/recompose_job.h"
#include "simulation/job/simulation_job.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

std::vector<simulation::LookChange> parse_changes(const std::vector<std::string>& texts,
                                                  const std::vector<std::string>& materials) {
  std::vector<simulation::LookChange> changes;
  for (const std::string& text : texts) {
    try {
      changes.push_back(simulation::parse_look_change(text, materials));
    } catch (const InvalidInput& e) {
      throw app::UsageError("--set: " + std::string(e.what()));
    }
  }
  return changes;
}

}  // namespace

int cmd_restyle(CommandRun& run) {
  fs::path folder, scene_path, output;
  std::vector<std::string> texts;
  simulation::RecomposeOptions options;
  device::DeviceOptions device;
  run.line.positional("SIMULATION", "A folder that `simulate` made", folder);
  run.line.output("FOLDER", "Folder to make: a simulation of the same amounts with another look", output);
  run.line.repeated("set", "MATERIAL.WHAT=VALUE",
                    "A post-control: strength, variation, specular, specular_variation, height (mm), grain (mm) or "
                    "height_variation of a material",
                    texts);
  run.line.option("scene", "SCENE",
                  "A scene file whose appearance parameters to take; default: the one that was simulated", scene_path);
  run.line.options(options);
  run.line.options(device);
  run.line.example("simulate restyle rust -o rust_pale --set rust.strength=0.5 --set rust.variation=0.8");
  if (!run.parse()) return 0;
  options.device = app::open_simulation_device(device, words_of(run));
  const simulation::SimulationManifest manifest = simulation::read_simulation_manifest(folder);
  simulation::SceneFile file =
      simulation::read_scene(scene_path.empty() ? manifest.scene : scene_path, run.control("scene"));
  const std::vector<simulation::LookChange> changes = parse_changes(texts, manifest.materials);
  const JobPlan plan = simulation::plan_recompose(folder, std::move(file), changes, options, output);
  if (plan.items.empty())
    run.note(folder.string() +
             " has no amounts for its frames (made by an earlier version): only its last state is composed");
  const std::optional<JobStatus> status = run.make_folder(plan, "restyle");
  if (status) run.report_output(*status, output);
  return 0;
}

}  // namespace patinate::cli
