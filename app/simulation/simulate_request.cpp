#include "app/simulation/simulate_request.h"

#include <algorithm>

#include "app/request/usage_error.h"
#include "libcommon/core/text.h"

namespace patinate::app {

void describe(OptionVisitor& v, SimulateOptions& o) {
  v.visit({"iterations", "How long it runs; 0 = as the scene says", "", between(0, 1e9)}, o.iterations);
  v.visit({"history_every", "Iterations from one frame of the history to the next; 0 = as the scene says", "",
           between(0, 1e9)},
          o.history_every);
  v.visit({"resolution", "Texels along each side of the atlas; 0 = as the scene says", "", between(0, 16384)},
          o.resolution);
  v.visit_choice({"color_form", "How colors mix: normalized weights, the published shader or the printed equation"},
                 o.color_form, simulation::kColorFormNames);
}

void require_resolution(const SimulateOptions& options) {
  if (options.resolution > 0 && options.resolution < 16)
    throw UsageError("--resolution: found `" + std::to_string(options.resolution) + "`; expected 0 or [16, 16384]");
}

simulation::SceneFile read_requested_scene(const SimulateRequest& request, const RunControl& control) {
  const SimulateOptions& options = request.options;
  require_resolution(options);
  simulation::SceneFile file = simulation::read_scene(request.scene, control);
  if (options.iterations > 0) file.iterations = options.iterations;
  if (options.history_every > 0) file.history_every = options.history_every;
  if (options.resolution > 0) file.scene.resolution = options.resolution;
  if (request.seed) file.scene.seed = static_cast<std::uint64_t>(*request.seed);
  const std::vector<std::string> names = simulation::parameter_map_names(file.scene.materials);
  for (const std::string& name : request.controls) {
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw UsageError("--controls: found `" + name + "`; expected a parameter map" + did_you_mean(name, names));
    if (std::find(file.controls.begin(), file.controls.end(), name) == file.controls.end())
      file.controls.push_back(name);
  }
  return file;
}

}  // namespace patinate::app
