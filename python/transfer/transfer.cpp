#include <algorithm>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/request/history_library.h"
#include "app/transfer/transfer_work.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/transfer/time_map.h"
#include "patinate/transfer/transfer_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "python/bindings.h"
#include "python/history/given_history.h"
#include "python/support/arrays.h"
#include "python/support/device_keyword.h"
#include "python/support/immutable.h"
#include "python/support/json.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/surface/py_surface.h"
#include "python/transfer/py_transfer.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

constexpr const char* kFunction = "transfer";
using AgedClass = py::class_<PyAged>;

/// Controls as they were asked for: words, or a map for a control of the history.
struct AskedControls {
  std::vector<transfer::ControlSpec> specs;
  std::vector<std::shared_ptr<ControlMap>>
      maps;  ///< A map for each; nullptr where the destination says how it is made.
};

/// A ControlMap, or values H x W in [0, 1].
std::shared_ptr<ControlMap> map_from(const py::object& given, const std::string& name) {
  if (py::isinstance<ControlMap>(given)) return py::cast<std::shared_ptr<ControlMap>>(given);
  auto map =
      std::make_shared<ControlMap>(ControlMap{.values = image_from(given, "controls[" + name + "]", 1), .unit = ""});
  map->has_file = true;  // Painted, as a map file is.
  for (const float v : map->values.values()) {
    if (!(v >= 0.0f && v <= 1.0f)) throw InvalidInput("controls[" + name + "]: holds a value outside [0, 1]");
  }
  return map;
}

AskedControls asked_from(const py::object& given) {
  AskedControls out;
  const auto add_text = [&](const std::string& text) {
    out.specs.push_back(transfer::parse_controls(std::span(&text, 1)).front());
    out.maps.push_back(nullptr);
  };
  if (py::isinstance<py::str>(given)) {
    add_text(py::cast<std::string>(given));
  } else if (py::isinstance<py::dict>(given)) {
    for (const auto& [key, value] : py::cast<py::dict>(given)) {
      const auto name = py::cast<std::string>(key);
      if (py::isinstance<py::str>(value)) {
        add_text(name + "=" + py::cast<std::string>(value));
      } else {
        out.specs.push_back({.source = name, .destination = "array"});
        out.maps.push_back(map_from(py::reinterpret_borrow<py::object>(value), name));
      }
    }
  } else if (py::isinstance<py::sequence>(given)) {
    for (const py::handle text : given) add_text(py::cast<std::string>(text));
  } else {
    wrong_type(kFunction, "controls", given, "a text, a list of texts, or a dict");
  }
  if (out.specs.empty()) throw InvalidInput("controls: there are none; give at least one, such as 'accessibility'");
  return out;
}

/// A ready map, if it lies on the surface.
ControlMap laid_map(const ControlMap& given, const std::string& name, const TexelMap& map) {
  if (given.values.width() == map.width() && given.values.height() == map.height()) return given;
  throw InvalidInput("controls[" + name + "]: is " + std::to_string(given.values.height()) + " x " +
                     std::to_string(given.values.width()) + "; the surface has " + std::to_string(map.height()) +
                     " x " + std::to_string(map.width()) + " texels (Surface(mesh) says where they lie)");
}

PyAged transferred(const PyHistory& history, const py::object& destination, const py::object& given,
                   const py::kwargs& kwargs) {
  Keywords keywords(kFunction, kwargs);
  TransferKeywords options;
  keywords.read(options);
  const DeviceKeyword device(keywords);
  const RunArguments run = keywords.run();
  keywords.finish();
  AskedControls asked = asked_from(given);
  asked.specs = transfer::with_sources(*history.value, std::move(asked.specs));
  const bool is_surface = py::isinstance<PySurface>(destination);
  if (!is_surface && !py::isinstance<PyMesh>(destination))
    wrong_type(kFunction, "destination", destination, "a Mesh or a Surface");
  const PySurface ready = is_surface ? py::cast<const PySurface&>(destination) : PySurface{};
  const PyMesh given_mesh = is_surface ? PyMesh{} : py::cast<const PyMesh&>(destination);
  const std::shared_ptr<const Mesh> mesh = given_mesh.value;
  const auto said = std::make_shared<std::vector<std::string>>();
  PyAged aged{std::make_shared<const transfer::AgedMesh>(result_of(run, [=](const RunControl& control) {
    transfer::AgeOptions age = options.age;
    if (age.transfer.method == transfer::TransferMethod::Fast)
      age.device = app::open_search_device(device.options(), device.words());
    else if (device.options().device != "auto" && device.options().device != "cpu")
      throw InvalidInput("device: method \"reference\" runs on the CPU; leave device out");
    const HistoryFacts& facts = history.value->facts();
    transfer::AgingSurface surface =
        mesh == nullptr ? ready.value
                        : transfer::make_aging_surface(*mesh, options.age, &facts, control.part(0.0, 0.2));
    if (mesh != nullptr) surface.name = given_mesh.name;
    const bool knows_unit = mesh == nullptr ? ready.has_unit : age.mm_per_unit.has_value();
    const bool knows_pixel = mesh == nullptr || age.texel_size_mm || facts.texel_size_mm;
    const app::Words say = collecting(said);
    note_sizes(surface,
               !knows_unit    ? transfer::ScaleSource::MeshScaled
               : !knows_pixel ? transfer::ScaleSource::PixelAssumed
                              : transfer::ScaleSource::Known,
               say);
    std::vector<transfer::TransferControl> pairs = app::noted_controls(
        *history.value, asked.specs, *surface.map,
        [&](std::size_t i, const transfer::ControlSpec& spec) {
          const double begin = 0.2 + 0.2 * static_cast<double>(i) / static_cast<double>(asked.specs.size());
          return asked.maps[i] ? laid_map(*asked.maps[i], spec.source, *surface.map)
                               : make_control_expression(spec.destination, *surface.map, options.age.controls,
                                                         control.part(begin, begin));
        },
        say);
    transfer::AgedMesh made =
        transfer::age_surface(history.value, surface, std::move(pairs), age, control.part(0.4, 1.0));
    for (const std::string& note :
         app::transfer_notes(app::FoundStructure{made.structure, made.refused_line_share, made.used}, made.asked))
      say.note(note);
    return made;
  }))};
  aged.notes = *said;
  device.warn();
  return aged;
}

/// Index of a tile; nothing for None. @throws InvalidInput listing those that there are.
std::optional<int> tile_from(const py::object& given, const Sheet& sheet) {
  if (given.is_none()) return std::nullopt;
  const auto name = py::cast<std::string>(given);
  const auto found = std::find(sheet.names.begin(), sheet.names.end(), name);
  if (found != sheet.names.end()) return static_cast<int>(found - sheet.names.begin());
  std::string list;
  for (const std::string& each : sheet.names) list += (list.empty() ? "`" : "`, `") + each;
  throw InvalidInput("tile: found `" + name + "`; expected one of " + list + "`");
}

using Look = std::function<ImageF(double time, const RunControl& control)>;

/// Images at one time, or at several with the times as first axis; over the sheet, or of one tile.
py::object looks_at(const AskedTime& at, const Sheet& sheet, std::optional<int> tile, const RunArguments& run,
                    const Look& look) {
  const std::vector<double> times = at.several.value_or(std::vector<double>{at.one});
  std::vector<ImageF> images = result_of(run, [=](const RunControl& control) {
    std::vector<ImageF> out;
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto n = static_cast<double>(times.size()), k = static_cast<double>(i);
      ImageF image = look(times[i], control.part(k / n, (k + 1.0) / n));
      out.push_back(tile ? cut_tile(image, sheet, *tile) : std::move(image));
    }
    return out;
  });
  if (!at.several) return array_of(std::move(images.front()));
  py::list arrays;
  for (ImageF& image : images) arrays.append(array_of(std::move(image)));
  return stacked(arrays);
}

void define_facts(AgedClass& type) {
  define_method(type, FunctionText("__repr__", "In a line.").returns("str"), [](const PyAged& aged) {
    const Sheet& sheet = aged.value->sheet();
    return "<patinate.AgedMesh of `" + aged.value->history->facts().name +
           "`: " + (sheet.num_tiles() > 1 ? std::to_string(sheet.num_tiles()) + " tiles of " : "") +
           size_text(sheet.tile_width, sheet.tile_height) + " texels, " +
           std::to_string(aged.value->mesh.num_triangles()) + " triangles>";
  });
  define_property(type, "mesh", "Mesh", "In mm, with UVs over the sheet of all tiles.", [](const PyAged& aged) {
    return PyMesh{std::shared_ptr<const Mesh>(aged.value, &aged.value->mesh)};
  });
  define_property(type, "surface", "Surface", "Where its texels lie.",
                  [](const PyAged& aged) { return surface_of(*aged.value); });
  define_property(type, "folder", "str | None", "Where it was read from; None of one that was made here.",
                  [](const PyAged& aged) { return aged.path.empty() ? py::object(py::none()) : py::str(aged.path); });
  define_copies(type);
  define_property(type, "history", "History", "What its colors are of.",
                  [](const PyAged& aged) { return PyHistory{aged.value->history}; });
  define_property(type, "tiles", "list[str]", "Names of the squares of its atlas; [''] of one alone.",
                  [](const PyAged& aged) {
                    py::list out;
                    for (const std::string& name : aged.value->sheet().names) out.append(name);
                    return out;
                  });
  define_property(type, "controls", "list[str]", "'SOURCE=DESTINATION' of each.", [](const PyAged& aged) {
    py::list out;
    if (aged.value->folder) {
      for (const transfer::RecordedControl& c : aged.value->folder->manifest().controls) out.append(c.text());
    } else {
      for (const transfer::TransferControl& c : aged.value->controls) out.append(c.source + "=" + c.destination);
    }
    return out;
  });
  define_property(
      type, "coordinates", "npt.NDArray[np.float32]",
      "H x W x 2 over the sheet: where in the history a texel looks, x and y in pixels, whole numbers in their "
      "middles; -1 outside; cannot be written.",
      [](const py::object& self) { return read_only(py::cast<const PyAged&>(self).value->coordinates, self); });
  define_property(
      type, "coverage", "npt.NDArray[np.bool_]", "H x W over the sheet: where texels show the surface.",
      [](const py::object& self) { return mask_array(ImageU8(py::cast<const PyAged&>(self).value->coverage)); });
  define_property(
      type, "notes", "list[str]",
      "What one should know of it, as the command says it: sizes that were chosen, controls without effect, "
      "lines that were found.",
      [](const PyAged& aged) {
        py::list out;
        for (const std::string& note : notes_of(aged)) out.append(note);
        return out;
      });
  define_property(type, "energy", "dict[str, Any]",
                  "The figures of transfer.json: energy, its parts, control error, coherence.",
                  [](const PyAged& aged) { return object_of(energy_json(aged.value->energy)); });
}

void define_save(AgedClass& type) {
  define_method(
      type,
      FunctionText("save",
                   "Writes the folder that the command `transfer` makes of the same input, byte for byte; "
                   "export(), render(), evaluate() and the commands take it.")
          .takes("folder", "str | os.PathLike[str]", "It appears when it is whole; a finished one stays as it is")
          .keyword("force", "bool", "False", "Replace a different transfer that lies there")
          .runs()
          .raises("InvalidInput if the history is in memory only, or this was read from a folder; CannotComplete if "
                  "something else lies there"),
      [](const PyAged& aged, const py::object& folder, const py::kwargs& kwargs) {
        Keywords keywords("save", kwargs);
        const bool force = keywords.flag("force", false);
        const RunArguments run = keywords.run();
        keywords.finish();
        const std::string path = path_from(folder);
        run_interruptibly(run, [=](const RunControl& control) {
          const bool is_installed = app::library_name(folder_of({aged.value->history})).has_value();
          aged.value->save(path, {.force = force, .is_history_installed = is_installed}, control);
        });
      });
}

constexpr const char* kTileType = "str | None";
constexpr const char* kTileHelp = "One of `tiles`; None: all of them, over the sheet as coverage";

void define_looks(AgedClass& type) {
  define_method(type,
                FunctionText("texture", "The surface's color at a time, gutters filled.")
                    .takes("time", "float | npt.ArrayLike",
                           "In the history's unit, clamped to its ends; or a list of times; or H x W over the sheet, a "
                           "time for every texel")
                    .keyword("tile", kTileType, "None", kTileHelp)
                    .options<SamplingOptions>()
                    .runs()
                    .returns("npt.NDArray[np.float32]", "H x W x 3, linear; of a list of times T x H x W x 3")
                    .raises("InvalidInput if a time is NaN or the sizes differ; IoError"),
                [](const PyAged& aged, const py::object& time, const py::kwargs& kwargs) {
                  Keywords keywords("texture", kwargs);
                  SamplingOptions options;
                  keywords.read(options);
                  const py::object tile = keywords.object("tile");
                  const RunArguments run = keywords.run();
                  keywords.finish();
                  const AskedTime at = time_from("texture", time);
                  const Sheet& sheet = aged.value->sheet();
                  return looks_at(at, sheet, tile_from(tile, sheet), run,
                                  [=, of = aged.value](double t, const RunControl& control) {
                                    return at.map ? of->texture(*at.map, options.between, control)
                                                  : of->texture(t, options.between, control);
                                  });
                });
  define_method(
      type,
      FunctionText("material_map",
                   "What the history's frames hold beside color, on the surface: relief, gloss, deviation.")
          .takes("name", "str", "One of history.material_maps")
          .takes("time", "float | Sequence[float]", "In the history's unit; or a list of times")
          .keyword("tile", kTileType, "None", kTileHelp)
          .options<SamplingOptions>()
          .runs()
          .returns("npt.NDArray[np.float32]", "H x W x 3 or H x W, gutters filled; of a list of times T x H x W (x 3)")
          .raises("InvalidInput if the history's frames do not hold it; IoError"),
      [](const PyAged& aged, const std::string& name, const py::object& time, const py::kwargs& kwargs) {
        Keywords keywords("material_map", kwargs);
        SamplingOptions options;
        keywords.read(options);
        const py::object tile = keywords.object("tile");
        const RunArguments run = keywords.run();
        keywords.finish();
        const AskedTime at = time_from("material_map", time);
        if (at.map) throw InvalidInput("time: expected a number, or a list of numbers");
        const MaterialMap map = material_map_from(name);
        const Sheet& sheet = aged.value->sheet();
        return looks_at(at, sheet, tile_from(tile, sheet), run,
                        [=, of = aged.value](double t, const RunControl& control) {
                          return of->material_map(map, t, options.between, control);
                        });
      });
}

void bind_gather(py::module_& module) {
  define(
      module,
      FunctionText("gather_at_times", "The history's color at every texel's own time.")
          .takes("history", "History", "")
          .takes("coordinates", "npt.ArrayLike",
                 "H x W x 2: places inside its frames in pixels, whole numbers in their middles, or -1")
          .takes("times", "npt.ArrayLike", "H x W, in its unit, clamped to its ends")
          .options<SamplingOptions>()
          .runs()
          .returns("npt.NDArray[np.float32]", "H x W x 3, linear; 0 where coordinates are -1")
          .raises("InvalidInput if sizes differ, a time is NaN or coordinates lie elsewhere, naming the texel"),
      [](const PyHistory& history, const py::object& coordinates, const py::object& times, const py::kwargs& kwargs) {
        Keywords keywords("gather_at_times", kwargs);
        SamplingOptions options;
        keywords.read(options);
        const RunArguments run = keywords.run();
        keywords.finish();
        ImageF at = image_from(coordinates, "coordinates", 2), when = image_from(times, "times", 1);
        ImageF colors = result_of(run, [=, at = std::move(at), when = std::move(when)](const RunControl& control) {
          return transfer::gather_at_times(*history.value, at, when, options.between, control);
        });
        return array_of(std::move(colors));
      });
}

}  // namespace

AskedTime time_from(const std::string& function, const py::object& time) {
  py::array array = py::array::ensure(time);
  if (!array) wrong_type(function, "time", time, "a number, a list of numbers, or H x W numbers");
  if (array.ndim() == 0) {  // As precise as it is given: what is held changes at a frame's very time.
    const double one = PyFloat_AsDouble(time.ptr());
    if (one == -1.0 && PyErr_Occurred() != nullptr) throw py::error_already_set();
    return {.one = one};
  }
  if (array.ndim() == 1) return {.several = numbers_from(time, "time")};
  if (array.dtype().kind() == 'i' || array.dtype().kind() == 'u') array = array.attr("astype")("float32");
  return {.map = image_from(array, "time", 1)};
}

void bind_transfer(py::module_& module) {
  const char* const doc =
      "A mesh and where each of its texels takes its color from, at all times: from transfer(), or read_transfer().";
  AgedClass type(module, "AgedMesh", doc);
  begin_class_stub("AgedMesh", doc);
  define_facts(type);
  define_save(type);
  define_looks(type);
  define(module,
         FunctionText("read_transfer", "Opens a transfer folder and the history that it names.")
             .takes("path", "str | os.PathLike[str]", "The folder, or its transfer.json")
             .returns("AgedMesh")
             .raises("IoError, also when the history has changed since"),
         [](const py::object& given) {
           const std::string path = path_from(given);
           return PyAged{
               .value = result_of({},
                                  [=](const RunControl&) {
                                    return std::make_shared<const transfer::AgedMesh>(transfer::read_aged_mesh(path));
                                  }),
               .path = path};
         });
  bind_gather(module);
  define(
      module,
      FunctionText(
          kFunction,
          "Ages a mesh as a history aged: for every texel the place of the history that it shows, once for all times.")
          .takes("history", "History | str | os.PathLike[str]", "With at least one control; or the path of one")
          .takes("destination", "Mesh | Surface", "A Surface keeps its texels; of a Mesh the keywords make one")
          .takes(
              "controls", "str | Sequence[str] | Mapping[str, str | ControlMap | npt.ArrayLike]",
              "'[SOURCE=]DESTINATION[:weight[:mapping]]' as --control of the command line, one or several; or by the "
              "history's control: such a DESTINATION, a ControlMap, or values H x W in [0, 1] over the surface")
          .options<TransferKeywords>()
          .options<device::DeviceOptions>()
          .runs()
          .returns("AgedMesh")
          .raises("ParseError if a control cannot be read; InvalidInput; IoError"),
      [](const py::object& history, const py::object& destination, const py::object& controls,
         const py::kwargs& kwargs) {
        return transferred(history_from(kFunction, "history", history), destination, controls, kwargs);
      });
}

}  // namespace patinate::python
