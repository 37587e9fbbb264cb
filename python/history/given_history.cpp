#include "python/history/given_history.h"

#include "app/request/path_kind.h"
#include "patinate/history/history.h"
#include "patinate/history/write_history.h"
#include "python/support/keywords.h"

namespace patinate::python {

namespace py = pybind11;

GivenHistory given_history(const std::string& function, const std::string& name, const py::object& given,
                           const std::string& what) {
  if (py::isinstance<PyHistory>(given)) {
    const auto& history = py::cast<const PyHistory&>(given);
    const std::filesystem::path folder = folder_of(history);
    return {.path = folder, .memory = folder.empty() ? history.value : nullptr};
  }
  if (!py::isinstance<py::str>(given) && !py::hasattr(given, "__fspath__")) wrong_type(function, name, given, what);
  return {.path = path_from(given)};
}

std::filesystem::path place_of(const GivenHistory& history, Rooms& rooms, const RunControl& control) {
  if (!history.memory) return app::history_place(history.path);
  const std::filesystem::path folder =
      rooms.emplace_back(std::filesystem::temp_directory_path(), "patinate_subject").path() / "history";
  write_history(folder, *history.memory, control.part(0.0, 0.0));
  return folder;
}

PyHistory history_from(const std::string& function, const std::string& name, const py::object& given) {
  if (py::isinstance<PyHistory>(given)) return py::cast<const PyHistory&>(given);
  const std::filesystem::path path = given_history(function, name, given).path;
  return {result_of(
      {}, [=](const RunControl&) { return std::make_shared<const HistoryReader>(app::history_place(path)); })};
}

}  // namespace patinate::python
