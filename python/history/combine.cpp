#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "app/history/layered_history.h"
#include "libcommon/job/job.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "python/bindings.h"
#include "python/history/given_history.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "transfer/library/library_job.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

/// {"age": ["thickness", "progress"]}
std::vector<transfer::LibraryControl> controls_from(const py::object& given, std::size_t num_histories) {
  std::vector<transfer::LibraryControl> controls;
  if (given.is_none()) return controls;
  for (const auto& [name, sources] : given.cast<py::dict>()) {
    transfer::LibraryControl control{.name = name.cast<std::string>(), .sources = {}};
    for (const py::handle& source : sources.cast<py::sequence>()) control.sources.push_back(source.cast<std::string>());
    if (control.sources.size() != num_histories)
      throw InvalidInput("controls: " + control.name + " names " + std::to_string(control.sources.size()) +
                         " controls for " + std::to_string(num_histories) + " histories");
    controls.push_back(std::move(control));
  }
  return controls;
}

}  // namespace

void bind_combine(py::module_& module) {
  define(module,
         FunctionText(
             "combine",
             "Lays several histories side by side in one, a library, of which transfer takes the place that fits; or "
             "puts the second inside the first (where).")
             .takes("histories", "Sequence[History | str | os.PathLike[str]]",
                    "Two or more that were opened or made, or folders of histories or simulations; they get the "
                    "indices 0, 1, ...")
             .takes("output", "str | os.PathLike[str]", "The folder to make; what is there already stays as it is")
             .keyword("controls", "dict[str, list[str]] | None", "None",
                      "Controls of the library, each made of one control of every history, in their order; controls "
                      "that all have under one name come by themselves")
             .keyword("where", "str", "''",
                      "The second history lies in the first where this is above a half, from that time on: an "
                      "expression of the first one's controls and of height (mm), metalness, roughness, lightness, "
                      "change")
             .keyword("force", "bool", "False", "Replace something different that lies there")
             .options<transfer::LibraryOptions>()
             .runs()
             .returns("History")
             .raises("IoError if a file cannot be read; InvalidInput if histories do not fit together; CannotComplete"),
         [](const py::sequence& histories, const py::object& output, const py::kwargs& kwargs) {
           Keywords keywords("combine", kwargs);
           transfer::LibraryTask task;
           keywords.read(task.options);
           std::vector<GivenHistory> given;
           for (const py::handle& history : histories)
             given.push_back(given_history("combine", "histories", py::reinterpret_borrow<py::object>(history)));
           task.controls = controls_from(keywords.object("controls"), given.size());
           const std::string where = keywords.text("where", "");
           if (!where.empty() && given.size() != 2)
             throw InvalidInput("where: needs two histories, the lower and the one that lies in it");
           const bool force = keywords.flag("force", false);
           const RunArguments run = keywords.run();
           keywords.finish();
           const std::string to = path_from(output);
           return PyHistory{result_of(run, [=](const RunControl& control) mutable {
             Rooms rooms;
             for (const GivenHistory& one : given) task.histories.push_back(place_of(one, rooms, control));
             const JobPlan plan =
                 where.empty() ? transfer::plan_library(transfer::open_library(std::move(task)), to)
                               : app::plan_layers(task.histories[0], task.histories[1], where, task.options.clock, to);
             run_job(plan, {.force = force}, control);
             return std::make_shared<const HistoryReader>(to);
           })};
         });
}

}  // namespace patinate::python
