// A finished simulation, opened where it ended.
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"
#include "simulation/job/simulation_job.h"
#include "simulation/job/simulation_output.h"
#include "tools/studio/live_engine.h"

namespace patinate::studio {

namespace {

constexpr const char* kStartAgain = "\"Back to the start\" runs its scene from there.";

}  // namespace

/// Its state; without one, the amounts that it ended with; the start of the scene where that is another now. Says
/// which.
void LiveEngine::open_finished() {
  const simulation::SimulationManifest manifest = simulation::read_simulation_manifest(options_.finished);
  record_.set_resolution(manifest.resolution);
  if (manifest.seed) record_.set_seed(*manifest.seed);
  if (const std::string changed = simulation::changed_inputs(options_.finished, file_); !changed.empty()) {
    opened_ = "Changed since this simulation was made: " + changed +
              ". So this is the start of the scene as it is now; the simulation's own end is its history.";
    return;
  }
  const simulation::Behavior start = file_.scene.behavior;
  const std::string ended =
      "This is where the simulation ended, after " + std::to_string(manifest.iterations) + " iterations. ";
  if (simulation::read_state_file(options_.finished, simulation_)) {
    opened_ = ended + "Run resumes from here; " + kStartAgain;
  } else {
    simulation::read_atlas_file(options_.finished, simulation_);
    for (const simulation::SceneEvent& event : file_.scene.events) {
      const bool has_happened = event.iteration < manifest.iterations;
      if (has_happened && !std::holds_alternative<simulation::PaintEvent>(event.what))
        simulation_.apply(event);  // everything stands where it stood; the strokes are in the amounts
    }
    picture_of_ = manifest.iterations;
    opened_ = ended + "Its folder has no state.bin, so its appearance parameters can change, but it cannot resume; " +
              kStartAgain;
  }
  const simulation::Behavior now = simulation_.scene().behavior;
  const bool is_same = now.bounce == start.bounce && now.floating == start.floating && now.absorb == start.absorb &&
                       now.deceleration_bounce == start.deceleration_bounce &&
                       now.deceleration_float == start.deceleration_float;
  if (!is_same) slider_.reset();
}

void LiveEngine::refuse_picture() const {
  if (picture_of_ > 0)
    throw InvalidInput(
        std::string(
            "the amounts of a finished simulation are shown, and its gammatons are not there to resume with; ") +
        kStartAgain);
}

std::int64_t LiveEngine::iteration() const { return picture_of_ > 0 ? picture_of_ : simulation_.iteration(); }

}  // namespace patinate::studio
