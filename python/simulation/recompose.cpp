#include <utility>

#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/support/device_keyword.h"
#include "python/support/signature.h"
#include "simulation/job/recompose_job.h"
#include "simulation/job/simulation_job.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

/// {"rust.strength": 0.5}
std::vector<simulation::LookChange> changes_from(const py::object& given, const std::vector<std::string>& materials) {
  std::vector<simulation::LookChange> changes;
  if (given.is_none()) return changes;
  if (!py::isinstance<py::dict>(given)) wrong_type("recompose", "changes", given, "a dict");
  for (const auto& [name, value] : py::cast<py::dict>(given)) {
    if (!py::isinstance<py::str>(name)) wrong_type("recompose", "changes", name, "a str as key");
    if (!py::isinstance<py::float_>(value) && !py::isinstance<py::int_>(value))
      wrong_type("recompose", "changes", value, "a number as value");
    try {
      changes.push_back(simulation::parse_look_change(
          py::cast<std::string>(name) + "=" + py::cast<std::string>(py::repr(value)), materials));
    } catch (const InvalidInput& e) {
      throw InvalidInput("changes: " + std::string(e.what()));
    }
  }
  return changes;
}

}  // namespace

void bind_recompose(py::module_& module) {
  define(module,
         FunctionText("recompose",
                      "Makes a simulation folder of the same amounts with another look: pictures, model, history.")
             .takes("simulation", "str | os.PathLike[str]", "A simulation's folder")
             .takes("output", "str | os.PathLike[str]", "The folder to make; what is there already stays as it is")
             .keyword("changes", "dict[str, float] | None", "None",
                      "Post-controls, as {\"rust.strength\": 0.5}: strength, variation, specular, specular_variation, "
                      "height (mm), grain (mm) or height_variation of a material")
             .keyword("scene", "str | os.PathLike[str] | None", "None",
                      "A scene file with the same materials whose looks to take")
             .keyword("force", "bool", "False", "Replace something different that lies there")
             .options<simulation::RecomposeOptions>()
             .options<device::DeviceOptions>()
             .runs()
             .returns("History")
             .raises("IoError if a file cannot be read or has other materials; InvalidInput; CannotComplete"),
         [](const py::object& simulation, const py::object& output, const py::kwargs& kwargs) {
           Keywords keywords("recompose", kwargs);
           simulation::RecomposeOptions options;
           keywords.read(options);
           const DeviceKeyword device(keywords);
           const py::object given = keywords.object("changes"), scene = keywords.object("scene");
           const bool force = keywords.flag("force", false);
           const RunArguments run = keywords.run();
           keywords.finish();
           const std::string from = path_from(simulation), to = path_from(output);
           const simulation::SimulationManifest manifest = simulation::read_simulation_manifest(from);
           const std::vector<simulation::LookChange> changes = changes_from(given, manifest.materials);
           const std::filesystem::path file =
               scene.is_none() ? manifest.scene : std::filesystem::path(path_from(scene));
           PyHistory made{result_of(run, [=](const RunControl& control) mutable {
             options.device = app::open_simulation_device(device.options(), device.words());
             run_job(simulation::plan_recompose(from, simulation::read_scene(file, control.part(0.0, 0.2)), changes,
                                                options, to),
                     {.force = force}, control.part(0.2, 1.0));
             return std::make_shared<const HistoryReader>(std::filesystem::path(to) / "history");
           })};
           device.warn();
           return made;
         });
}

}  // namespace patinate::python
