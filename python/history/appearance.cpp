#include <filesystem>
#include <memory>
#include <utility>

#include "app/history/stated_appearance.h"
#include "libcommon/job/job.h"
#include "patinate/history/history.h"
#include "python/bindings.h"
#include "python/history/given_history.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

void bind_appearance(py::module_& module) {
  define(module,
         FunctionText("appearance",
                      "Makes a history folder with maps of what its material is stated to be: metalness, roughness, "
                      "strength and color of the mirror.")
             .takes("history", "History | str | os.PathLike[str]", "One that was opened or made, or its folder")
             .takes("output", "str | os.PathLike[str]", "The folder to make; what is there already stays as it is")
             .keyword("statement", "str | os.PathLike[str] | None", "None",
                      "A file that says it by color, over time, or by control or mask; without it, the numbers below")
             .keyword("force", "bool", "False", "Replace something different that lies there")
             .options<app::PlainAppearance>()
             .runs()
             .returns("History")
             .raises("IoError if a file cannot be read; InvalidInput also if the history has such maps already, or "
                     "unless either a statement or numbers are given; CannotComplete"),
         [](const py::object& history, const py::object& output, const py::kwargs& kwargs) {
           Keywords keywords("appearance", kwargs);
           app::PlainAppearance plain;
           keywords.read(plain);
           const py::object statement = keywords.object("statement");
           const bool force = keywords.flag("force", false);
           const RunArguments run = keywords.run();
           keywords.finish();
           const GivenHistory from = given_history("appearance", "history", history);
           const std::string to = path_from(output);
           const std::filesystem::path file = statement.is_none() ? std::string() : path_from(statement);
           return PyHistory{result_of(run, [=](const RunControl& control) {
             Rooms rooms;
             run_job(app::plan_appearance(place_of(from, rooms, control), app::appearance_of(file, plain), to),
                     {.force = force}, control);
             return std::make_shared<const HistoryReader>(to);
           })};
         });
}

}  // namespace patinate::python
