#include <filesystem>
#include <memory>
#include <utility>

#include "capture/relief/relief_job.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/job/job.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

void bind_relief(py::module_& module) {
  define(module,
         FunctionText("relief",
                      "Measures how much higher or lower a surface stands from scan to scan, with deviation, "
                      "significance and volume.")
             .takes("registered", "str | os.PathLike[str]",
                    "A folder of `patinate register`, or its registration.json: scans in the order of time")
             .takes("output", "str | os.PathLike[str]",
                    "The folder to make: a history with heights, change maps, relief.json, relief.csv, report.html")
             .keyword("stable", "str | os.PathLike[str] | None", "None",
                      "An image of the maps' size, white where the surface is known to stay")
             .keyword("times", "Sequence[float] | None", "None", "When the scans were made; None: 0, 1, ...")
             .keyword("time_unit", "str", "'d'", "s, min, h, d or a")
             .keyword("unit", "str | None", "None", "um, mm, cm or m, where the registration does not say it")
             .keyword("force", "bool", "False", "Replace something different that lies there")
             .options<capture::ReliefOptions>()
             .runs()
             .returns("History", "With `height` in every frame: mm along the reference's normal")
             .raises("IoError if a file cannot be read; InvalidInput if scans share no stable surface, or times do not "
                     "increase; CannotComplete"),
         [](const py::object& registered, const py::object& output, const py::kwargs& kwargs) {
           Keywords keywords("relief", kwargs);
           capture::ReliefOptions options;
           keywords.read(options);
           const py::object stable = keywords.object("stable"), times = keywords.object("times");
           const std::string time_unit = keywords.text("time_unit", "d");
           const std::string unit = keywords.text("unit", "");
           const bool force = keywords.flag("force", false);
           const RunArguments run = keywords.run();
           keywords.finish();
           std::optional<double> mm_per_unit;
           if (!unit.empty()) {
             mm_per_unit = find_mm_per_unit(unit);
             if (!mm_per_unit) throw InvalidInput("unit: found `" + unit + "`; expected um, mm, cm or m");
           }
           const std::string from = path_from(registered), to = path_from(output);
           const std::string mask = stable.is_none() ? std::string() : path_from(stable);
           const std::vector<double> given = times.is_none() ? std::vector<double>() : numbers_from(times, "times");
           return PyHistory{result_of(run, [=](const RunControl& control) {
             capture::ReliefTask task = capture::relief_task_of(from, mm_per_unit);
             task.name = std::filesystem::path(to).filename().string();
             task.stable = mask;
             task.time_unit = parse_time_unit(time_unit);
             task.options = options;
             capture::set_times(given, task);
             run_job(capture::plan_relief(std::move(task), to), {.force = force}, control);
             return std::make_shared<const HistoryReader>(to);
           })};
         });
}

}  // namespace patinate::python
