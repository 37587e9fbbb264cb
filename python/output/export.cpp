#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "app/output/export_work.h"
#include "app/request/history_library.h"
#include "libcommon/core/temporary_file.h"
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

/// What is exported: a folder, or what has one.
struct Subject {
  std::filesystem::path folder;
  std::shared_ptr<const transfer::AgedMesh> aged = nullptr;  ///< In memory: saved for the time of the export.
};

Subject subject_from(const py::object& given) {
  if (py::isinstance<PyAged>(given)) {
    const auto& aged = py::cast<const PyAged&>(given);
    return {.folder = aged.path, .aged = aged.path.empty() ? aged.value : nullptr};
  }
  if (py::isinstance<PyHistory>(given)) {
    const std::filesystem::path folder = folder_of(py::cast<const PyHistory&>(given));
    if (folder.empty()) throw InvalidInput("the history is in memory only: save it, and export its folder");
    return {.folder = folder};
  }
  return {.folder = path_from(given)};
}

}  // namespace

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
    const Subject given = subject_from(subject);
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
      std::optional<TemporaryFolder> saved;
      if (given.aged) {
        saved.emplace(std::filesystem::temp_directory_path(), "patinate_export");
        task.subject = saved->path() / "aged";
        given.aged->save(task.subject, {}, control.part(0.0, 0.0));
      } else {
        task.subject = app::library_place(task.subject);
      }
      task.devices = app::output_devices(device.options(), device.words());
      app::make_output(app::export_work(task, control), force, control);
    });
    device.warn();
  });
}

}  // namespace patinate::python
