#include <filesystem>
#include <string>
#include <utility>

#include "python/simulation/py_simulation.h"
#include "simulation/job/simulation_job.h"

namespace patinate::python {

void PySimulation::save(const std::string& folder, bool force, const RunArguments& run) {
  alone(run, [state = state_, folder, force](simulation::Simulation& running, const RunControl& control) {
    std::optional<TemporaryFolder> room;
    simulation::SceneFile read =
        simulation::read_scene(state->scene.written(room, control.part(0.0, 0.05)), control.part(0.05, 0.1));
    read.scene.resolution = state->file.scene.resolution;
    read.scene.seed = state->file.scene.seed;
    read.controls = state->options.parameter_maps;
    const JobPlan plan = simulation::plan_saved_simulation(
        std::move(read), state->options,
        {running.iteration(), running.snapshot(), state->is_changed_by_hand, state->has_set_amounts}, folder);
    (void)run_job(plan, {.force = force}, control.part(0.1, 1.0));
  });
}

}  // namespace patinate::python
