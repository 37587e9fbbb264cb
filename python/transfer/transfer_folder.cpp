#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/transfer/time_map.h"
#include "patinate/transfer/transfer_reader.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/support/arrays.h"
#include "python/support/device_keyword.h"
#include "python/support/json.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/surface/py_surface.h"
#include "python/transfer/py_transfer.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

using TransferClass = py::class_<PyTransfer>;

/// The tiles of one square alone are the texture itself.
py::object tiles_of(std::vector<ImageF> tiles) {
  if (tiles.size() == 1) return array_of(std::move(tiles.front()));
  py::list out;
  for (ImageF& tile : tiles) out.append(array_of(std::move(tile)));
  return out;
}

/// As tiles_of(), each tile with the times as its first axis.
py::object textures_at(const std::shared_ptr<const transfer::TransferReader>& transfer,
                       const std::vector<double>& times, const SamplingOptions& options, const RunArguments& run) {
  std::vector<py::list> by_tile(transfer->manifest().tiles.size());
  for (const double time : times) {
    std::vector<ImageF> tiles = result_of(
        run, [=](const RunControl& control) { return transfer->sample_tiles(time, options.between, control); });
    for (std::size_t i = 0; i < tiles.size(); ++i) by_tile[i].append(array_of(std::move(tiles[i])));
  }
  if (by_tile.size() == 1) return stacked(by_tile.front());
  py::list out;
  for (const py::list& tile : by_tile) out.append(stacked(tile));
  return out;
}

void define_facts(TransferClass& type) {
  define_method(type, FunctionText("__repr__", "In a line.").returns("str"), [](const PyTransfer& t) {
    const transfer::TransferManifest& m = t.value->manifest();
    return "<patinate.Transfer `" + t.path + "` of `" + m.history_name +
           "`: " + (m.tiles.size() > 1 ? std::to_string(m.tiles.size()) + " tiles of " : "") +
           size_text(m.width, m.height) + " texels>";
  });
  define_property(type, "mesh", "Mesh", "In mm, with UVs over the sheet of all tiles.",
                  [](const PyTransfer& t) { return PyMesh{std::shared_ptr<const Mesh>(t.value, &t.value->mesh())}; });
  define_property(type, "history", "History", "What its colors are of.", [](const PyTransfer& t) {
    return PyHistory{std::shared_ptr<const History>(t.value, &t.value->history())};
  });
  define_property(type, "tiles", "list[str]", "Names of the squares of its atlas; [''] of one alone.",
                  [](const PyTransfer& t) {
                    py::list out;
                    for (const transfer::TransferTile& tile : t.value->manifest().tiles) out.append(tile.name);
                    return out;
                  });
  define_property(type, "controls", "list[str]", "'SOURCE=DESTINATION' of each.", [](const PyTransfer& t) {
    py::list out;
    for (const transfer::RecordedControl& c : t.value->manifest().controls) out.append(c.text());
    return out;
  });
  define_property(
      type, "coordinates", "npt.NDArray[np.float32]",
      "H x W x 2 over the sheet: where in the history a texel looks, x and y in pixels, whole numbers in their "
      "middles; -1 outside; cannot be written.",
      [](const py::object& self) { return read_only(py::cast<const PyTransfer&>(self).value->coordinates(), self); });
  define_property(type, "energy", "dict[str, Any]", "The figures of transfer.json.",
                  [](const PyTransfer& t) { return object_of(energy_json(t.value->manifest().energy)); });
  define_property(type, "key", "str", "Content key.", [](const PyTransfer& t) { return t.value->manifest().key; });
  define_method(type,
                FunctionText("coverage", "Where texels show the surface.").returns("npt.NDArray[np.bool_]", "H x W"),
                [](const PyTransfer& t) { return mask_array(t.value->coverage()); });
}

}  // namespace

void bind_transfer_folder(py::module_& module) {
  const char* const doc = "A finished transfer folder, looked up at any time.";
  TransferClass type(module, "Transfer", doc);
  begin_class_stub("Transfer", doc);
  define_facts(type);
  define_method(
      type,
      FunctionText("texture", "The surface's color at a time, gutters filled: what `patinate lookup` writes.")
          .takes("time", "float | npt.ArrayLike",
                 "In the history's unit, clamped to its ends; or a list of times; or H x W over the sheet, a time for "
                 "every texel")
          .options<SamplingOptions>()
          .runs()
          .returns("npt.NDArray[np.float32] | list[npt.NDArray[np.float32]]",
                   "H x W x 3, linear; of a list of times T x H x W x 3; of several tiles one each")
          .raises("InvalidInput if a time is NaN or the sizes differ; IoError"),
      [](const PyTransfer& t, const py::object& time, const py::kwargs& kwargs) {
        Keywords keywords("texture", kwargs);
        SamplingOptions options;
        keywords.read(options);
        const RunArguments run = keywords.run();
        keywords.finish();
        const AskedTime at = time_from(time);
        if (at.several) return textures_at(t.value, *at.several, options, run);
        std::vector<ImageF> tiles = result_of(run, [=](const RunControl& control) {
          return at.map ? t.value->sample_tiles(*at.map, options.between, control)
                        : t.value->sample_tiles(at.one, options.between, control);
        });
        return tiles_of(std::move(tiles));
      });
  define_method(type,
                FunctionText("material_map",
                             "What the history's frames hold beside color, on the surface: relief, gloss, deviation.")
                    .takes("name", "str", "One of history.material_maps")
                    .takes("time", "float", "In the history's unit")
                    .options<SamplingOptions>()
                    .runs()
                    .returns("npt.NDArray[np.float32]", "H x W x 3 or H x W over the sheet, gutters filled")
                    .raises("InvalidInput; IoError"),
                [](const PyTransfer& t, const std::string& name, double time, const py::kwargs& kwargs) {
                  Keywords keywords("material_map", kwargs);
                  SamplingOptions options;
                  keywords.read(options);
                  const RunArguments run = keywords.run();
                  keywords.finish();
                  for (std::size_t i = 0; i < kMaterialMapNames.size(); ++i) {
                    if (kMaterialMapNames[i] != name) continue;
                    ImageF values = result_of(run, [=](const RunControl& control) {
                      return t.value->sample_map(static_cast<MaterialMap>(i), time, options.between, control);
                    });
                    return array_of(std::move(values));
                  }
                  throw InvalidInput("material_map: found `" + name +
                                     "`; expected normal, roughness, specular, height, stddev, metalness or tint");
                });
  define(module,
         FunctionText("read_transfer", "Opens a transfer folder and the history that it names.")
             .takes("path", "str | os.PathLike[str]", "The folder, or its transfer.json")
             .returns("Transfer")
             .raises("IoError, also when the history has changed since"),
         [](const py::object& given) {
           const std::string path = path_from(given);
           return PyTransfer{
               .value = result_of(
                   {}, [=](const RunControl&) { return std::make_shared<const transfer::TransferReader>(path); }),
               .path = path};
         });
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

}  // namespace patinate::python
