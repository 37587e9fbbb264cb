#include <nlohmann/json.hpp>
#include <utility>

#include "app/history/history_shelf.h"
#include "app/request/history_library.h"
#include "python/analysis/py_series.h"
#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/json.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

/// Subject that is compared with the library, opened where it is a path.
std::function<analysis::TextureSeries()> subject_from(const py::object& given) {
  if (std::optional<analysis::TextureSeries> series = series_in_memory(given)) return [series] { return *series; };
  if (py::isinstance<py::str>(given) || py::hasattr(given, "__fspath__")) {
    return [path = path_from(given)] { return app::series_or_photograph(app::library_place(path)); };
  }
  if (!py::isinstance<py::array>(given))
    wrong_type("library", "like", given, "a path, a History, an AgedMesh, or H x W x 3 linear colors");
  return [photograph = image_from(given, "like", 3)] { return app::series_of_photograph(photograph, "photograph"); };
}

py::dict shelf_dict(const std::vector<app::ShelfEntry>& entries, const std::vector<app::Likeness>& ranking) {
  py::dict out;
  for (const app::Likeness& likeness : ranking) {
    const app::ShelfEntry& entry = entries[likeness.entry];
    py::object facts = object_of(entry.json());
    facts["likeness"] = object_of(likeness.json());
    out[entry.name.c_str()] = facts;
  }
  if (ranking.empty()) {
    for (const app::ShelfEntry& entry : entries) out[entry.name.c_str()] = object_of(entry.json());
  }
  return out;
}

}  // namespace

void bind_library(py::module_& module) {
  define(module,
         FunctionText("library",
                      "The histories to start from, for read_history(\"library:NAME\"); with `like`, the most similar "
                      "first: by colors, coarseness, and when places change.")
             .keyword("like", "str | os.PathLike[str] | History | AgedMesh | npt.ArrayLike | None", "None",
                      "A history, simulation, transfer or photograph, or its path; of a photograph as an array H x W x "
                      "3, linear")
             .runs()
             .returns("Report",
                      "By name, in alphabetical order: title, frames, duration, time_unit, controls, license and what "
                      "else `patinate history library --json` says; with `like` also likeness: total (0: the same), "
                      "colors_delta_e, structure_octaves, rates_spans. Empty where no library is installed")
             .raises("IoError, InvalidInput"),
         [](const py::kwargs& kwargs) {
           Keywords keywords("library", kwargs);
           const py::object like = keywords.object("like");
           const RunArguments run = keywords.run();
           keywords.finish();
           const auto subject = like.is_none() ? nullptr : subject_from(like);
           const auto [entries, ranking] = result_of(run, [=](const RunControl& control) {
             std::vector<app::ShelfEntry> shelf = app::history_shelf();
             std::vector<app::Likeness> likenesses;
             if (subject) likenesses = app::rank_by_likeness(subject(), shelf, control);
             return std::pair(std::move(shelf), std::move(likenesses));
           });
           return shelf_dict(entries, ranking);
         });
}

}  // namespace patinate::python
