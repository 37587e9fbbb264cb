#include "patinate/history/history.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "app/request/path_kind.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/history/write_history.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/support/arrays.h"
#include "python/support/immutable.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

Between between_from(const std::string& name) {
  // The one home of the names is the description of the options.
  SamplingOptions options;
  py::kwargs given;
  given["between"] = name;
  Keywords keywords("between", given);
  keywords.read(options);
  return options.between;
}

MaterialMap material_map_from(const std::string& name) {
  std::string list;
  for (std::size_t i = 0; i < kMaterialMapNames.size(); ++i) {
    if (kMaterialMapNames[i] == name) return static_cast<MaterialMap>(i);
    list += (i == 0 ? "" : i + 1 < kMaterialMapNames.size() ? ", " : " or ") + std::string(kMaterialMapNames[i]);
  }
  throw InvalidInput("material_map: found `" + name + "`; expected " + list);
}

std::filesystem::path folder_of(const PyHistory& history) {
  const auto* const reader = dynamic_cast<const HistoryReader*>(history.value.get());
  return reader == nullptr ? std::filesystem::path() : reader->folder();
}

namespace {

using HistoryClass = py::class_<PyHistory>;

void define_facts(HistoryClass& type) {
  define_property(type, "name", "str", "What the material is called.",
                  [](const PyHistory& h) { return h.value->facts().name; });
  define_property(type, "label", "str", "What messages call it: its folder, or its name.",
                  [](const PyHistory& h) { return h.value->label(); });
  define_property(type, "origin", "str", "captured, simulated or synthetic.",
                  [](const PyHistory& h) { return h.value->facts().origin; });
  define_property(type, "width", "int", "Pixels.", [](const PyHistory& h) { return h.value->facts().width; });
  define_property(type, "height", "int", "Pixels.", [](const PyHistory& h) { return h.value->facts().height; });
  define_property(type, "times", "npt.NDArray[np.float64]",
                  "Of the frames, in time_unit, increasing; cannot be written.", [](const PyHistory& h) {
                    py::array times = array_of(h.value->times());
                    times.attr("flags").attr("writeable") = false;
                    return times;
                  });
  define_property(type, "time_unit", "str", "s, min, h, d or a.",
                  [](const PyHistory& h) { return time_unit_text(h.value->facts().time_unit); });
  define_property(
      type, "texel_size_mm", "float | None", "Surface length of a pixel, where it is known.", [](const PyHistory& h) {
        return h.value->facts().texel_size_mm ? py::object(py::float_(*h.value->facts().texel_size_mm)) : py::none();
      });
  define_property(type, "controls", "dict[str, tuple[float, float, str]]",
                  "Controls by name: what 0 and what 1 stand for, and the unit.", [](const PyHistory& h) {
                    py::dict out;
                    for (const ControlFacts& c : h.value->facts().controls)
                      out[c.name.c_str()] = py::make_tuple(c.low, c.high, c.unit);
                    return out;
                  });
  define_property(type, "maps", "list[str]", "Maps that are constant in time.", [](const PyHistory& h) {
    py::list out;
    for (const std::string& name : h.value->facts().maps) out.append(name);
    return out;
  });
  define_property(type, "material_maps", "list[str]", "What frames hold beside color: what material_map() gives.",
                  [](const PyHistory& h) {
                    py::list out;
                    for (const MaterialMap map : material_maps(h.value->facts()))
                      out.append(std::string(kMaterialMapNames[static_cast<std::size_t>(map)]));
                    return out;
                  });
  define_property(type, "warnings", "list[str]", "What may be wrong with it, the worst first.", [](const PyHistory& h) {
    py::list out;
    for (const HistoryWarning& warning : h.value->facts().warnings) out.append(warning_text(warning));
    return out;
  });
}

void define_images(HistoryClass& type) {
  define_method(type,
                FunctionText("frame", "Color of one frame.")
                    .takes("index", "int", "From 0; below 0: from the end")
                    .returns("npt.NDArray[np.float32]", "H x W x 3, linear")
                    .raises("InvalidInput, IoError"),
                [](const PyHistory& h, int index) {
                  const int from_start = index < 0 ? index + h.value->num_frames() : index;
                  return array_of(result_of({}, [=](const RunControl&) { return h.value->read_frame(from_start); }));
                });
  define_method(
      type,
      FunctionText("sample", "Color at any time, between frames too; clamped to the ends.")
          .takes("time", "float", "In time_unit")
          .options<SamplingOptions>()
          .returns("npt.NDArray[np.float32]", "H x W x 3, linear; at a frame's time exactly that frame")
          .raises("InvalidInput if the time is NaN; IoError"),
      [](const PyHistory& h, double time, const py::kwargs& kwargs) {
        Keywords keywords("sample", kwargs);
        SamplingOptions options;
        keywords.read(options);
        keywords.finish();
        return array_of(result_of({}, [=](const RunControl&) { return sample(*h.value, time, options.between); }));
      });
  define_method(type,
                FunctionText("control", "A control parameter at every pixel.")
                    .takes("name", "str", "One of `controls`")
                    .returns("npt.NDArray[np.float32]", "H x W in [0, 1]; controls[name] says what 0 and 1 stand for")
                    .raises("InvalidInput, IoError"),
                [](const PyHistory& h, const std::string& name) {
                  return array_of(result_of({}, [=](const RunControl&) { return h.value->read_control(name); }));
                });
  define_method(type,
                FunctionText("control_deviation", "Standard deviation of a control.")
                    .takes("name", "str", "One of `controls`")
                    .returns("npt.NDArray[np.float32] | None", "H x W, >= 0, in the same units; None: not known")
                    .raises("InvalidInput, IoError"),
                [](const PyHistory& h, const std::string& name) -> py::object {
                  auto deviation =
                      result_of({}, [=](const RunControl&) { return h.value->read_control_deviation(name); });
                  if (!deviation) return py::none();
                  return array_of(std::move(*deviation));
                });
  define_method(type,
                FunctionText("mask", "Where the history shows the surface.").returns("npt.NDArray[np.bool_]", "H x W"),
                [](const PyHistory& h) {
                  return mask_array(result_of({}, [=](const RunControl&) { return h.value->read_mask(); }));
                });
  define_method(type,
                FunctionText("frame_mask", "Where one frame shows the surface itself: the mask, and the frame's own.")
                    .takes("index", "int", "From 0")
                    .returns("npt.NDArray[np.bool_]", "H x W"),
                [](const PyHistory& h, int index) {
                  return mask_array(result_of({}, [=](const RunControl&) { return h.value->read_frame_mask(index); }));
                });
  define_method(
      type,
      FunctionText("map", "A map that is constant in time.")
          .takes("name", "str", "One of `maps`")
          .returns("npt.NDArray[np.float32]", "H x W x 3 (position in mm, normal) or H x W (mm); 0: no surface")
          .raises("InvalidInput, IoError"),
      [](const PyHistory& h, const std::string& name) {
        return array_of(result_of({}, [=](const RunControl&) { return h.value->read_map(name); }));
      });
  define_method(
      type,
      FunctionText("material_map", "What frames hold beside color, at any time: relief, gloss, deviation.")
          .takes("name", "str", "One of `material_maps`")
          .takes("time", "float", "In time_unit")
          .options<SamplingOptions>()
          .returns("npt.NDArray[np.float32]",
                   "normal: unit, tangent space, H x W x 3; roughness, specular, height (mm), metalness: H x W; "
                   "stddev, tint: H x W x 3")
          .raises("InvalidInput, IoError"),
      [](const PyHistory& h, const std::string& name, double time, const py::kwargs& kwargs) {
        Keywords keywords("material_map", kwargs);
        SamplingOptions options;
        keywords.read(options);
        keywords.finish();
        const MaterialMap map = material_map_from(name);
        return array_of(result_of(
            {}, [=](const RunControl&) { return sample_material_map(*h.value, map, time, options.between); }));
      });
}

}  // namespace

void bind_history(py::module_& module) {
  const char* const doc =
      "A material history: color of a surface over time, with its controls. Immutable; read frame by frame.";
  HistoryClass type(module, "History", doc);
  begin_class_stub("History", doc);
  define_facts(type);
  define_images(type);
  define_method(type, FunctionText("__len__", "Number of frames.").returns("int"),
                [](const PyHistory& h) { return h.value->num_frames(); });
  define_method(
      type,
      FunctionText("__getitem__", "Color of one frame, as frame(); so that a history is a sequence of frames.")
          .takes("index", "int", "From 0; below 0: from the end")
          .returns("npt.NDArray[np.float32]", "H x W x 3, linear")
          .raises("IndexError, IoError"),
      [](const PyHistory& h, int index) {
        const int from_start = index < 0 ? index + h.value->num_frames() : index;
        if (from_start < 0 || from_start >= h.value->num_frames())
          throw py::index_error("frame " + std::to_string(index) + " of " + std::to_string(h.value->num_frames()));
        return array_of(result_of({}, [=](const RunControl&) { return h.value->read_frame(from_start); }));
      });
  define_method(type,
                FunctionText("__iter__", "Its frames, one after another.").returns("Iterator[npt.NDArray[np.float32]]"),
                [](const py::object& self) { return py::reinterpret_steal<py::object>(PySeqIter_New(self.ptr())); });
  define_method(type, FunctionText("__repr__", "In a line.").returns("str"), [](const PyHistory& h) {
    const HistoryFacts& f = h.value->facts();
    return "<patinate.History `" + f.name + "`: " + std::to_string(f.frames.size()) + " frames of " +
           size_text(f.width, f.height) + ", " + number_text(f.frames.front().time) + " to " +
           number_text(f.frames.back().time) + " " + time_unit_text(f.time_unit) + ">";
  });
  define_property(type, "folder", "str | None", "Where it lies; None of one in memory.",
                  [](const PyHistory& h) -> py::object {
                    const std::filesystem::path folder = folder_of(h);
                    return folder.empty() ? py::object(py::none()) : py::str(folder.string());
                  });
  define_copies(type);
  define_method(
      type,
      FunctionText("save", "Writes it as a new folder, which appears when it is whole; colors as half floats.")
          .takes("folder", "str | os.PathLike[str]", "Must not exist, or be empty")
          .keyword("force", "bool", "False", "Replace a history that lies there")
          .runs()
          .raises("CannotComplete if something is there or it cannot be written"),
      [](const PyHistory& h, const py::object& folder, const py::kwargs& kwargs) {
        Keywords keywords("save", kwargs);
        const bool force = keywords.flag("force", false);
        const RunArguments run = keywords.run();
        keywords.finish();
        const std::string path = path_from(folder);
        run_interruptibly(run, [=](const RunControl& control) { write_history(path, *h.value, control, force); });
      });
  define(module,
         FunctionText("read_history", "Opens a history folder; pixels are read when they are asked for.")
             .takes("path", "str | os.PathLike[str]",
                    "The folder, its history.json, a simulation's folder, or `library:NAME`")
             .returns("History")
             .raises("IoError naming the file"),
         [](const py::object& path) {
           const std::string folder = path_from(path);
           return PyHistory{result_of({}, [=](const RunControl&) {
             return std::make_shared<const HistoryReader>(app::history_place(folder));
           })};
         });
}

}  // namespace patinate::python
