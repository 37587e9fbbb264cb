#include <utility>

#include "app/simulation/simulate_request.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/simulation/scene_argument.h"
#include "python/support/device_keyword.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "simulation/job/simulation_job.h"

namespace patinate::python {

namespace py = pybind11;

void bind_simulate(py::module_& module) {
  FunctionText text("simulate",
                    "Runs a scene to its end and keeps it as `patinate simulate` does: pictures, model, maps, history. "
                    "What export(), render(), recompose(), transfer() and Simulation() take.");
  text.takes("scene", kSceneType, "A scene file, or what would stand in one")
      .takes("output", "str | os.PathLike[str]", "The folder to make; what is there already stays as it is");
  scene_text(text)
      .keyword("controls", "Sequence[str]", "()",
               "Parameter maps beside those that the scene asks for: hits, last_hit, water.deposited, ...")
      .keyword("seed", "int | None", "None", "Of all random numbers (>= 0); None: the scene's")
      .keyword("force", "bool", "False", "Replace something different that lies there")
      .options<app::SimulateOptions>()
      .options<device::DeviceOptions>()
      .runs()
      .returns("History")
      .raises("IoError naming file and JSON pointer; InvalidInput; CannotComplete");
  define(module, text, [](const py::object& scene, const py::object& output, const py::kwargs& kwargs) {
    Keywords keywords("simulate", kwargs);
    const SceneArgument given = scene_from("simulate", scene, keywords);
    app::SimulateRequest request;
    keywords.read(request.options);
    const DeviceKeyword device(keywords);
    const py::object controls = keywords.object("controls");
    if (!controls.is_none()) {
      for (const py::handle name : controls) request.controls.push_back(py::cast<std::string>(name));
    }
    if (const py::object seed = keywords.object("seed"); !seed.is_none()) {
      request.seed = py::cast<std::int64_t>(seed);
      if (*request.seed < 0)
        throw InvalidInput("seed: " + std::to_string(*request.seed) + " is out of range; use >= 0");
    }
    const bool force = keywords.flag("force", false);
    const RunArguments run = keywords.run();
    keywords.finish();
    const std::filesystem::path to = path_from(output);
    PyHistory made{result_of(run, [=](const RunControl& control) mutable {
      std::optional<TemporaryFolder> room;
      request.scene = given.written(room, control.part(0.0, 0.05));
      simulation::SimulationOptions options;
      options.color_form = request.options.color_form;
      options.device = app::open_simulation_device(device.options(), device.words());
      run_job(simulation::plan_simulation(app::read_requested_scene(request, control.part(0.05, 0.1)), options, to),
              {.force = force}, control.part(0.1, 1.0));
      return std::make_shared<const HistoryReader>(to / "history");
    })};
    device.warn();
    return made;
  });
}

}  // namespace patinate::python
