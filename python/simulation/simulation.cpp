#include <algorithm>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <memory>
#include <utility>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/simulation/py_simulation.h"
#include "python/support/arrays.h"
#include "python/support/device_keyword.h"
#include "python/support/json.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/surface/py_surface.h"
#include "simulation/files/scene_event.h"
#include "simulation/job/reopened_simulation.h"
#include "simulation/transport/parameter_maps.h"

namespace patinate::python {

namespace py = pybind11;
using simulation::Simulation;

namespace {

/// The folder of a finished or saved simulation, or its manifest.
bool is_simulation_folder(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(manifest_folder(path, "simulation.json") / "simulation.json", error);
}

}  // namespace

std::shared_ptr<PySimulation::State> PySimulation::opened(const std::filesystem::path& folder,
                                                          const DeviceKeyword& device, const RunControl& control) {
  simulation::ReopenedSimulation reopened =
      simulation::reopen_simulation(folder, app::open_simulation_device(device.options(), device.words()), control);
  auto made = std::make_shared<State>();
  made->scene.file = reopened.file.file;
  made->file = std::move(reopened.file);
  made->options = std::move(reopened.options);
  made->running.emplace(std::move(reopened.simulation));
  made->is_changed_by_hand = made->has_set_amounts = reopened.is_changed_by_hand;
  return made;
}

PySimulation::PySimulation(const py::object& given, const py::kwargs& kwargs) {
  Keywords keywords("Simulation", kwargs);
  const py::object maps = keywords.object("parameter_maps");
  const bool is_asked = !maps.is_none();
  bool is_changed = is_asked;
  for (const char* name : {"folder", "meshes", "resolution", "seed"})
    is_changed = is_changed || keywords.is_given(name);
  const SceneArgument scene = scene_from("Simulation", given, keywords);
  const std::int64_t resolution = keywords.integer("resolution", 0), seed = keywords.integer("seed", -1);
  device_.emplace(keywords);
  const RunArguments run = keywords.run();
  keywords.finish();
  if (seed < -1) throw InvalidInput("seed: " + std::to_string(seed) + " is out of range; use >= 0, or -1: the scene's");
  const bool is_saved = !scene.root && is_simulation_folder(scene.file);
  if (is_saved && is_changed)
    throw InvalidInput("scene: a saved simulation goes on as it was made; leave the keywords out");
  std::vector<std::string> names;
  if (is_asked) {
    for (const py::handle name : maps) names.push_back(py::cast<std::string>(name));
  }
  state_ = result_of(run, [=, device = *device_](const RunControl& control) {
    if (is_saved) return opened(scene.file, device, control);
    auto made = std::make_shared<State>();
    made->scene = scene;
    made->file = scene.read(control);
    if (resolution != 0) made->file.scene.resolution = checked_resolution(resolution);
    if (seed >= 0) made->file.scene.seed = static_cast<std::uint64_t>(seed);
    made->options.device = app::open_simulation_device(device.options(), device.words());
    made->options.parameter_maps = is_asked ? names : made->file.controls;
    made->running.emplace(made->file.scene, made->options, control);
    return made;
  });
  device_->warn();
}

namespace {

using SimulationClass = py::class_<PySimulation, std::shared_ptr<PySimulation>>;

RunArguments run_of(const char* function, const py::kwargs& kwargs) {
  Keywords keywords(function, kwargs);
  RunArguments run = keywords.run();
  keywords.finish();
  return run;
}

/// Mass in amounts x texels of median size.
double mass_of(const simulation::MassSum& sum) {
  return sum.value() / (static_cast<double>(simulation::kAmountOne) * simulation::SurfaceAtlas::kMedianWeight);
}

void define_run(SimulationClass& type) {
  define_method(
      type,
      FunctionText("step", "Iterations: events of the scene, tracing, exchange, response, rules.")
          .keyword("count", "int", "1", "How many (>= 0)")
          .runs()
          .raises("KeyboardInterrupt on Ctrl-C; the iteration under way is finished first, and the state is whole"),
      [](PySimulation& s, const py::kwargs& kwargs) {
        Keywords keywords("step", kwargs);
        const std::int64_t count = keywords.integer("count", 1);
        const RunArguments run = keywords.run();
        keywords.finish();
        s.step(count, run);
      });
  define_method(
      type,
      FunctionText("apply", "What a scene's events do, now: an element of its \"events\" without the iteration.")
          .takes("event", "Mapping[str, Any]",
                 "{'op': 'move', 'target': 'rain', 'position': [0, 1, 0]}; lengths in the scene's unit")
          .runs()
          .raises(
              "InvalidInput for an unknown target or a value out of range, nothing is changed then; KeyboardInterrupt "
              "on Ctrl-C: the state may then be lost, as in step()"),
      [](PySimulation& s, const py::object& event, const py::kwargs& kwargs) {
        const RunArguments run = run_of("apply", kwargs);
        Json json = json_from(event, "event");
        if (!json.is_object() || json.contains("iteration"))
          throw InvalidInput("event: expected a dict without `iteration`: it happens now");
        const double mm_per_unit = s.file().mm_per_unit;
        s.change(run, [=](Simulation& running, const RunControl& control) mutable {
          json["iteration"] = running.iteration();
          running.apply(simulation::parse_event(json, running.scene(), mm_per_unit), control);
        });
      });
  define_method(
      type,
      FunctionText(
          "paint",
          "A brush alone: an emitter's gammatons are born at a place and go to their next contact; time stands still.")
          .takes("emitter", "str", "Its name; of any shape but sky")
          .takes("position", "Sequence[float]", "x, y, z in mm")
          .runs()
          .raises(
              "InvalidInput, nothing is changed then; KeyboardInterrupt on Ctrl-C: the state may then be lost, as in "
              "step()"),
      [](PySimulation& s, const std::string& emitter, const py::object& position, const py::kwargs& kwargs) {
        const RunArguments run = run_of("paint", kwargs);
        const Vec3 position_mm = vector_from(position, "position");
        s.change(run,
                 [=](Simulation& running, const RunControl& control) { running.paint(emitter, position_mm, control); });
      });
  define_method(type,
                FunctionText("snapshot", "Everything that changes while it runs; equal states give equal bytes.")
                    .returns("bytes"),
                [](PySimulation& s) {
                  const auto bytes =
                      s.alone({}, [](Simulation& running, const RunControl&) { return running.snapshot(); });
                  return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                });
  define_method(
      type,
      FunctionText("save",
                   "Writes the folder that `patinate simulate` makes with as many iterations, and frames at both ends; "
                   "the same bytes where it was only stepped. render(), export(), recompose() and transfer() take it.")
          .takes("folder", "str | os.PathLike[str]", "It appears when it is whole; a finished one stays as it is")
          .keyword("force", "bool", "False", "Replace a different simulation that lies there")
          .runs()
          .raises("CannotComplete if something else lies there"),
      [](PySimulation& s, const py::object& folder, const py::kwargs& kwargs) {
        Keywords keywords("save", kwargs);
        const bool force = keywords.flag("force", false);
        const RunArguments run = keywords.run();
        keywords.finish();
        s.save(path_from(folder), force, run);
      });
  define_method(type,
                FunctionText("restore", "Back to a snapshot of a simulation of the same scene and options.")
                    .takes("snapshot", "bytes", "As snapshot() gave it")
                    .raises("InvalidInput if it is of another; nothing is changed then"),
                [](PySimulation& s, const py::bytes& snapshot) { s.restore(snapshot); });
}

void define_pictures(SimulationClass& type) {
  define_method(type,
                FunctionText("compose", "What it looks like now. Looking never changes what happens next.")
                    .runs()
                    .returns("dict[str, npt.NDArray[Any]]",
                             "color: H x W x 3 linear floats; color_srgb: the same as uint8 codes; specular: H x W "
                             "uint8; normal: H x W x 3 uint8 "
                             "(127.5 + 127.5 n, frame of glTF); height_mm: H x W floats; gutters filled"),
                [](PySimulation& s, const py::kwargs& kwargs) {
                  const RunArguments run = run_of("compose", kwargs);
                  struct Look {
                    ImageF color, height_mm;
                    ImageU8 codes, specular, normal;
                  };
                  Look look = s.alone(run, [](Simulation& running, const RunControl& control) {
                    const simulation::Composer& composed = running.compose(control);
                    return Look{composed.color_linear(), composed.height_mm(), composed.color_srgb8(),
                                composed.specular8(), composed.normal8()};
                  });
                  py::dict out;
                  out["color"] = array_of(std::move(look.color));
                  out["color_srgb"] = array_of(std::move(look.codes));
                  out["specular"] = array_of(std::move(look.specular));
                  out["normal"] = array_of(std::move(look.normal));
                  out["height_mm"] = array_of(std::move(look.height_mm));
                  return out;
                });
  define_method(
      type,
      FunctionText("amounts", "How much of a material lies on every texel.")
          .takes("material", "str", "One of `materials`")
          .returns("npt.NDArray[np.float32]", "H x W, [0, 4); 0 outside the charts")
          .raises("InvalidInput listing the materials"),
      [](PySimulation& s, const std::string& name) {
        const int material = s.material(name);
        return array_of(s.alone({}, [=](Simulation& running, const RunControl&) { return running.amounts(material); }));
      });
  define_method(
      type,
      FunctionText("set_amounts",
                   "Takes amounts over from elsewhere, rounded to 1 / 16384; the ledger then no longer describes them.")
          .takes("material", "str", "One of `materials`")
          .takes("amounts", "npt.ArrayLike", "H x W, [0, 4)")
          .raises("InvalidInput"),
      [](PySimulation& s, const std::string& name, const py::object& given) {
        const int material = s.material(name);
        const ImageF amounts = image_from(given, "amounts", 1);
        s.set_amounts(material, amounts);
      });
  define_method(type,
                FunctionText("parameter_map", "A map that counted along the way, or the state at the end.")
                    .takes("name", "str", "One of parameter_maps, or MATERIAL.final")
                    .returns("tuple[npt.NDArray[np.float32], str]", "H x W, 0 outside the charts; and its unit")
                    .raises("InvalidInput for one that was not asked for"),
                [](PySimulation& s, const std::string& name) {
                  simulation::ParameterMap map =
                      s.alone({}, [=](Simulation& running, const RunControl&) { return running.parameter_map(name); });
                  return py::make_tuple(array_of(std::move(map.values)), map.unit);
                });
  define_method(
      type, FunctionText("coverage", "Where texels show the surface.").returns("npt.NDArray[np.bool_]", "H x W"),
      [](PySimulation& s) {
        return mask_array(s.alone({}, [](Simulation& running, const RunControl&) { return running.coverage(); }));
      });
}

void define_facts(SimulationClass& type) {
  define_property(type, "iteration", "int", "Iterations done.",
                  [](PySimulation& s) { return s.look([](Simulation& running) { return running.iteration(); }); });
  define_property(type, "time", "float", "In time_unit.",
                  [](PySimulation& s) { return s.look([](Simulation& running) { return running.time(); }); });
  define_property(type, "time_unit", "str", "s, min, h, d or a.",
                  [](const PySimulation& s) { return time_unit_text(s.file().time_unit); });
  define_property(type, "num_iterations", "int", "How many the scene file asks for.",
                  [](const PySimulation& s) { return s.file().iterations; });
  define_property(type, "materials", "list[str]", "In the scene's order.", [](const PySimulation& s) {
    py::list out;
    for (const std::string& name : s.file().scene.materials) out.append(name);
    return out;
  });
  define_property(type, "notes", "list[str]", "Unusual but allowed things that one should know of.",
                  [](PySimulation& s) {
                    py::list out;
                    for (const std::string& note : s.file().notes) out.append(note);
                    for (const std::string& note : s.look([](Simulation& running) { return running.notes(); }))
                      out.append(note);
                    return out;
                  });
  define_property(type, "texel_size_mm", "float", "Median over the surface.",
                  [](PySimulation& s) { return s.look([](Simulation& running) { return running.texel_size_mm(); }); });
  define_property(
      type, "mesh", "Mesh", "All objects where they are now, in mm, with UVs over the atlas.", [](PySimulation& s) {
        return PyMesh{s.alone(
            {}, [](Simulation& running, const RunControl&) { return std::make_shared<const Mesh>(running.mesh()); })};
      });
  define_method(
      type,
      FunctionText("ledger", "Where all mass is, by material; a mass of 1 is an amount of 1 on a texel of median size.")
          .returns("dict[str, dict[str, float]]",
                   "emitted + made = on_surfaces + carried + left + absorbed + rested + used; imbalance is exactly 0"),
      [](PySimulation& s) {
        const simulation::MassLedger ledger = s.look([](Simulation& running) { return running.ledger(); });
        py::dict out;
        for (std::size_t i = 0; i < s.file().scene.materials.size(); ++i) {
          const simulation::MassAccount& a = ledger.account(static_cast<int>(i));
          py::dict account;
          account["emitted"] = mass_of(a.emitted);
          account["made"] = mass_of(a.made);
          account["on_surfaces"] = mass_of(a.on_surfaces);
          account["carried"] = mass_of(a.carried);
          account["left"] = mass_of(a.left);
          account["absorbed"] = mass_of(a.absorbed);
          account["rested"] = mass_of(a.rested);
          account["used"] = mass_of(a.used);
          account["imbalance"] = mass_of(a.imbalance());
          out[s.file().scene.materials[i].c_str()] = account;
        }
        return out;
      });
}

}  // namespace

void bind_simulation(py::module_& module) {
  const char* const doc =
      "Gammatons age a scene: apply what an artist does, step, look. Simulation(scene, *, parameter_maps=None, ...). "
      "The same bits for any "
      "number of threads; not for several threads at once.";
  SimulationClass type(module, "Simulation", doc);
  begin_class_stub("Simulation", doc);
  FunctionText init("__init__",
                    "Reads a scene and everything that it names, or opens what was saved: it goes on as if it had not "
                    "been interrupted.");
  init.takes("scene", kSceneType,
             "A scene file, or what would stand in one; or the folder of save() or simulate(), without keywords but "
             "device");
  scene_text(init)
      .keyword("parameter_maps", "Sequence[str] | None", "None",
               "What to count along the way: hits, last_hit, rust.deposited, ...; None: what the scene asks for")
      .keyword("resolution", "int", "0", "Texels along the atlas ([16, 16384]); 0: the scene's")
      .keyword("seed", "int", "-1", "Of all random numbers (>= 0); -1: the scene's")
      .options<device::DeviceOptions>()
      .runs()
      .raises("IoError naming file and JSON pointer; InvalidInput");
  type.def(py::init([](const py::object& scene, const py::kwargs& kwargs) {
             return std::make_shared<PySimulation>(scene, kwargs);
           }),
           FunctionText(init).of_class().docstring().c_str(), py::arg("scene"));
  add_stub(FunctionText(init).of_class().stub());
  define_facts(type);
  define_run(type);
  define_pictures(type);
}

}  // namespace patinate::python
