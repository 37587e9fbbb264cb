#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/output/render_work.h"
#include "patinate/core/error.h"
#include "python/bindings.h"
#include "python/output/keywords.h"
#include "python/support/arrays.h"
#include "python/support/device_keyword.h"
#include "python/support/errors.h"
#include "python/transfer/py_transfer.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

struct RenderKeywords {
  app::ShownOptions shown = {};
  SurfaceOptions surface = {};
  RenderOptions options = {};
};
void describe(OptionVisitor& v, RenderKeywords& o) {
  describe(v, o.shown);
  describe(v, o.surface);
  describe(v, o.options);
}

struct MovieKeywords {
  MovieOptions movie = {};
  app::TurnOptions turn = {};
};
void describe(OptionVisitor& v, MovieKeywords& o) {
  describe(v, o.movie);
  describe(v, o.turn);
}

std::string keyword_of(const app::SurfaceFiles::Named& file) {
  std::string name = file.name;
  for (char& c : name) c = c == '-' ? '_' : c;
  return name;
}

void say_subject(FunctionText& text) {
  times_text(text)
      .keyword("views", "str | Sequence[str]", "''",
               "Several pictures: front, left, back, right, top, bottom or AZIMUTH:ELEVATION")
      .keyword("turntable", "int | None", "None", "So many pictures evenly around the up axis, from azimuth on")
      .keyword("target", "Sequence[float] | None", "None",
               "What the camera looks at, in the mesh's unit (mm of a transfer or simulation); None: its middle")
      .keyword("distance", "float | None", "None", "From the camera to the target; None: so that the mesh fits")
      .keyword("environment", "str | os.PathLike[str] | None", "None",
               "Surroundings that light the object: a picture of 360 x 180 degrees, HDR or EXR")
      .keyword("unit", "str | None", "None", "Of a mesh with a height_map: um, mm, cm or m; None: m for glTF, else mm");
  for (const app::SurfaceFiles::Named& file : app::SurfaceFiles::named())
    text.keyword(keyword_of(file), "str | os.PathLike[str] | None", "None", std::string(file.help));
  text.options<RenderKeywords>().options<device::DeviceOptions>();
}

std::filesystem::path optional_path(const py::object& path) { return path.is_none() ? std::string() : path_from(path); }

std::string views_from(const py::object& given) {
  if (given.is_none() || py::isinstance<py::str>(given)) return given.is_none() ? "" : py::cast<std::string>(given);
  std::string list;
  for (const py::handle view : given) list += (list.empty() ? "" : ",") + py::cast<std::string>(view);
  return list;
}

app::RenderTask task_from(Keywords& keywords) {
  app::RenderTask task;
  RenderKeywords options;
  task.is_width_given = keywords.is_given("width");
  task.is_height_given = keywords.is_given("height");
  keywords.read(options);
  task.shown = options.shown;
  task.surface = options.surface;
  task.options = options.options;
  task.times = times_from(keywords);
  task.views.views = views_from(keywords.object("views"));
  task.views.turntable = keywords.number("turntable");
  const py::object target = keywords.object("target");
  if (!target.is_none()) task.views.target = numbers_from(target, "target");
  task.views.distance = keywords.number("distance");
  task.environment = optional_path(keywords.object("environment"));
  task.unit = keywords.text("unit", "");
  for (const app::SurfaceFiles::Named& file : app::SurfaceFiles::named())
    task.files.*file.file = optional_path(keywords.object(keyword_of(file)));
  return task;
}

/// The picture as an array. @param notes  What the command would say.
py::object picture_of(app::RenderTask task, const py::object& subject, const RunArguments& run,
                      std::vector<std::string>& notes) {
  Subject given;
  if (py::isinstance<PyAged>(subject))
    task.mesh = std::make_shared<const app::AgingMesh>(app::aging_mesh_of(py::cast<const PyAged&>(subject).value));
  else
    given = subject_from("render", subject);
  auto [picture, said] = result_of(run, [=](const RunControl& control) mutable {
    Rooms rooms;
    if (!task.mesh) task.subject = place_of(given, rooms, control);
    const app::OutputWork work = app::render_work(std::move(task));
    return std::pair(work.picture(control), work.notes);
  });
  notes = std::move(said);
  return array_of(std::move(picture));
}

/// @returns what the command would say.
std::vector<std::string> write_picture(app::RenderTask task, const py::object& subject, const py::object& output,
                                       bool force, const RunArguments& run) {
  const Subject given = subject_from("render", subject);
  task.output = path_from(output);
  if (task.output.empty()) throw InvalidInput("output: is empty; expected the name of a picture or movie");
  return result_of(run, [=](const RunControl& control) mutable {
    Rooms rooms;
    task.subject = place_of(given, rooms, control);
    const app::OutputWork work = app::render_work(std::move(task));
    app::make_output(work, force, control);
    return work.notes;
  });
}

}  // namespace

void bind_render(py::module_& module) {
  FunctionText text("render",
                    "A picture of what ages: what `patinate render` writes, to a file, or without one as an array. A "
                    "file that is up to date stays as it is.");
  text.takes("subject", "AgedMesh | History | str | os.PathLike[str]",
             "A transfer or a history, opened or made here, or the path of a transfer, a simulation, a history, or a "
             "mesh with a texture")
      .takes("output", "str | os.PathLike[str] | None",
             "Image to make: .png, .jpg, .tif or .exr; of a transfer or simulation also a movie (.mp4, .webm, .gif) or "
             "images aged_%04d.png; None: an array is returned",
             "None");
  say_subject(text);
  text.keyword("force", "bool", "False", "Replace something different that lies there")
      .options<MovieKeywords>()
      .runs()
      .returns(
          "npt.NDArray[np.float32] | None",
          "Without output H x W x 3, linear, of one view or a strip with labels; srgb_from_linear() makes codes of it")
      .raises(
          "IoError if a file cannot be read; InvalidInput if what is asked for does not go together; "
          "CannotComplete");
  const auto render = [](const py::object& subject, const py::object& output, const py::kwargs& kwargs) {
    Keywords keywords("render", kwargs);
    app::RenderTask task = task_from(keywords);
    MovieKeywords options;
    keywords.read(options);
    const DeviceKeyword device(keywords);
    task.movie = options.movie;
    task.turn = options.turn;
    const bool force = keywords.flag("force", false);
    const RunArguments run = keywords.run();
    keywords.finish();
    task.devices = app::output_devices(device.options(), device.words());
    py::object picture = py::none();
    std::vector<std::string> notes;
    if (output.is_none())
      picture = picture_of(std::move(task), subject, run, notes);
    else
      notes = write_picture(std::move(task), subject, output, force, run);
    device.warn();
    warn_of(notes);
    return picture;
  };
  add_stub(text.stub());
  module.def("render", render, text.docstring().c_str(), py::arg("subject"), py::arg("output") = py::none());
}

}  // namespace patinate::python
