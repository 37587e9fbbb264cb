#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "libcommon/core/temporary_file.h"
#include "patinate/mesh_files/mesh_io.h"
#include "python/simulation/py_simulation.h"
#include "simulation/files/scene_files.h"
#include "simulation/job/simulation_job.h"

namespace patinate::python {

namespace fs = std::filesystem;

namespace {

/// Writes a scene that is no file, with its meshes, into `folder`. @param base  What its paths lead from.
/// @returns its file
fs::path write_scene(Json root, const fs::path& base, const MeshesByPath& meshes, const fs::path& folder) {
  std::size_t count = 0;
  simulation::for_each_scene_path(root, [&](Json& path) {
    const auto given = meshes.find(base / path.get<std::string>());
    if (given == meshes.end()) return simulation::move_scene_path(path, fs::absolute(base), folder);
    const std::string name = "mesh" + std::to_string(count++) + ".obj";
    write_obj(folder / name, *given->second);
    path = name;
  });
  save_json(folder / "scene.json", root);
  return folder / "scene.json";
}

}  // namespace

void PySimulation::save(const std::string& folder, bool force, const RunArguments& run) {
  alone(run, [state = state_, folder, force](simulation::Simulation& running, const RunControl& control) {
    const TemporaryFolder scene(fs::temp_directory_path(), "patinate_scene");
    fs::path file = state->file.file;
    if (!fs::is_regular_file(file)) {
      file = write_scene(*state->root, file.parent_path(), state->meshes, scene.path());
    }
    simulation::SceneFile read = simulation::read_scene(file, control.part(0.0, 0.1));
    read.scene.resolution = state->file.scene.resolution;
    read.scene.seed = state->file.scene.seed;
    const JobPlan plan = simulation::plan_saved_simulation(
        std::move(read), state->options,
        {running.iteration(), running.snapshot(), state->is_changed_by_hand, state->has_set_amounts}, folder);
    (void)run_job(plan, {.force = force}, control.part(0.1, 1.0));
  });
}

}  // namespace patinate::python
