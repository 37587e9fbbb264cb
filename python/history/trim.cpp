#include <algorithm>
#include <climits>
#include <memory>
#include <utility>

#include "app/history/trimmed_history.h"
#include "libcommon/job/job.h"
#include "patinate/history/history.h"
#include "python/bindings.h"
#include "python/history/given_history.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

void bind_trim(py::module_& module) {
  define(module,
         FunctionText("trim", "Makes a history folder of part of another one's frames, to hold the others out.")
             .takes("history", "History | str | os.PathLike[str]",
                    "One that was opened or made, or a folder of a history or a simulation")
             .takes("output", "str | os.PathLike[str]", "The folder to make; what is there already stays as it is")
             .keyword("start", "float | None", "None",
                      "First time that stays, in the history's unit: the command's --from, a word of Python's own")
             .keyword("until", "float | None", "None", "Last time that stays")
             .keyword("every", "int", "1", "Of those frames every n-th stays, the first among them; >= 1")
             .keyword("force", "bool", "False", "Replace something different that lies there")
             .runs()
             .returns("History")
             .raises("IoError if a file cannot be read; InvalidInput if no frame stays; CannotComplete"),
         [](const py::object& history, const py::object& output, const py::kwargs& kwargs) {
           Keywords keywords("trim", kwargs);
           TrimOptions options;
           options.from = keywords.number("start");
           options.until = keywords.number("until");
           options.every = static_cast<int>(std::clamp<std::int64_t>(keywords.integer("every", 1), INT_MIN, INT_MAX));
           const bool force = keywords.flag("force", false);
           const RunArguments run = keywords.run();
           keywords.finish();
           const GivenHistory from = given_history("trim", "history", history);
           const std::string to = path_from(output);
           return PyHistory{result_of(run, [=](const RunControl& control) {
             Rooms rooms;
             run_job(app::plan_trim(place_of(from, rooms, control), options, to), {.force = force}, control);
             return std::make_shared<const HistoryReader>(to);
           })};
         });
}

}  // namespace patinate::python
