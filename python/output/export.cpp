#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "app/output/export_work.h"
#include "app/request/history_library.h"
#include "patinate/core/error.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/output/keywords.h"
#include "python/support/arrays.h"
#include "python/support/device_keyword.h"
#include "python/transfer/py_transfer.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

struct ExportKeywords {
  app::SequenceFormat format = {};
  MovieOptions movie = {};
  app::ModelAxis axis = {};
};
void describe(OptionVisitor& v, ExportKeywords& o) {
  describe(v, o.format);
  describe(v, o.movie);
  describe(v, o.axis);
}

}  // namespace

Subject subject_from(const std::string& function, const py::object& given) {
  if (py::isinstance<PyAged>(given)) {
    const auto& aged = py::cast<const PyAged&>(given);
    return {.folder = aged.path, .aged = aged.path.empty() ? aged.value : nullptr};
  }
  if (py::isinstance<PyHistory>(given)) {
    const std::filesystem::path folder = folder_of(py::cast<const PyHistory&>(given));
    if (folder.empty()) throw InvalidInput("subject: the history is in memory only; save() it, and give its folder");
    return {.folder = folder};
  }
  if (!py::isinstance<py::str>(given) && !py::hasattr(given, "__fspath__"))
    wrong_type(function, "subject", given, "an AgedMesh, a History or a path");
  return {.folder = path_from(given)};
}

std::filesystem::path place_of(const Subject& subject, std::optional<TemporaryFolder>& room,
                               const RunControl& control) {
  if (!subject.aged) return app::library_place(subject.folder);
  room.emplace(std::filesystem::temp_directory_path(), "patinate_subject");
  subject.aged->save(room->path() / "aged", {}, control.part(0.0, 0.0));
  return room->path() / "aged";
}

FunctionText& times_text(FunctionText& text) {
  return text.keyword("time", "float | None", "None", "One time, in the history's unit")
      .keyword("times", "Sequence[float] | None", "None", "Several times")
      .keyword("num_times", "int | None", "None", "So many times, evenly from the first frame to the last");
}

app::TimesChoice times_from(Keywords& keywords) {
  app::TimesChoice choice;
  choice.time = keywords.number("time");
  const py::object times = keywords.object("times");
  if (!times.is_none()) choice.times = numbers_from(times, "times");
  choice.count = keywords.number("num_times");
  return choice;
}

void bind_export(py::module_& module) {
  FunctionText text("export",
                    "Writes a model, a movie or images of what ages: what `patinate export` writes. What is up to date "
                    "stays as it is.");
  text.takes("subject", "str | os.PathLike[str] | AgedMesh | History",
             "A transfer or simulation, or for pictures a history: the folder, or what was opened or made here")
      .takes("output", "str | os.PathLike[str]",
             "MODEL.glb with one variant a time; MODEL.usdz or .usda with textures over time; MODEL.obj with MTL at "
             "one time; MOVIE.mp4, .webm or .gif; images aged_%04d.png; or a folder of images");
  times_text(text)
      .keyword("force", "bool", "False", "Replace something different that lies there")
      .options<ExportKeywords>()
      .options<device::DeviceOptions>()
      .runs()
      .raises(
          "IoError if a file cannot be read; InvalidInput if what is asked for does not go together; "
          "CannotComplete");
  define(module, text, [](const py::object& subject, const py::object& output, const py::kwargs& kwargs) {
    Keywords keywords("export", kwargs);
    ExportKeywords options;
    keywords.read(options);
    const Subject given = subject_from("export", subject);
    app::ExportTask task{.subject = given.folder,
                         .output = path_from(output),
                         .times = times_from(keywords),
                         .format = options.format,
                         .movie = options.movie,
                         .axis = options.axis,
                         .devices = {}};
    const DeviceKeyword device(keywords);
    const bool force = keywords.flag("force", false);
    const RunArguments run = keywords.run();
    keywords.finish();
    run_interruptibly(run, [=](const RunControl& control) mutable {
      std::optional<TemporaryFolder> room;
      task.subject = place_of(given, room, control);
      task.devices = app::output_devices(device.options(), device.words());
      app::make_output(app::export_work(task, control), force, control);
    });
    device.warn();
  });
}

}  // namespace patinate::python
