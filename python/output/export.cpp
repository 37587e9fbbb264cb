#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/output/export_work.h"
#include "app/request/history_library.h"
#include "patinate/history/history.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/output/keywords.h"
#include "python/support/arrays.h"
#include "python/support/device_keyword.h"
#include "python/support/errors.h"
#include "python/transfer/py_transfer.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

struct ExportKeywords {
  app::SequenceFormat format = {};
  MovieOptions movie = {};
  app::ModelAxis axis = {};
  app::FlakeOptions flakes = {};
};
void describe(OptionVisitor& v, ExportKeywords& o) {
  describe(v, o.format);
  describe(v, o.movie);
  describe(v, o.axis);
  describe(v, o.flakes);
}

}  // namespace

Subject subject_from(const std::string& function, const py::object& given) {
  if (!py::isinstance<PyAged>(given))
    return {.given = given_history(function, "subject", given, "an AgedMesh, a History or a path")};
  const auto& aged = py::cast<const PyAged&>(given);
  return {.given = {.path = aged.path}, .aged = aged.path.empty() ? aged.value : nullptr};
}

std::filesystem::path place_of(const Subject& subject, Rooms& rooms, const RunControl& control) {
  if (!subject.aged) {
    return subject.given.memory ? place_of(subject.given, rooms, control) : app::library_place(subject.given.path);
  }
  const std::filesystem::path folder =
      rooms.emplace_back(std::filesystem::temp_directory_path(), "patinate_subject").path() / "aged";
  const RunControl silent = control.part(0.0, 0.0);
  const PyHistory history{subject.aged->history};
  if (!folder_of(history).empty()) {
    subject.aged->save(folder, {}, silent);
    return folder;
  }
  transfer::AgedMesh of_folder = *subject.aged;
  of_folder.history = std::make_shared<const HistoryReader>(
      place_of(GivenHistory{.path = "", .memory = history.value}, rooms, control));
  of_folder.save(folder, {}, silent);
  return folder;
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
    app::ExportTask task{.subject = {},
                         .output = path_from(output),
                         .times = times_from(keywords),
                         .format = options.format,
                         .movie = options.movie,
                         .axis = options.axis,
                         .flakes = options.flakes,
                         .devices = {}};
    const DeviceKeyword device(keywords);
    const bool force = keywords.flag("force", false);
    const RunArguments run = keywords.run();
    keywords.finish();
    const std::vector<std::string> notes = result_of(run, [=](const RunControl& control) mutable {
      Rooms rooms;
      task.subject = place_of(given, rooms, control);
      task.devices = app::output_devices(device.options(), device.words());
      const app::OutputWork work = app::export_work(task, control);
      app::make_output(work, force, control);
      return work.notes;
    });
    device.warn();
    warn_of(notes);
  });
}

}  // namespace patinate::python
