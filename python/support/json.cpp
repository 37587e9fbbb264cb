#include "python/support/json.h"

#include <nlohmann/json.hpp>
#include <string>

#include "patinate/core/error.h"

namespace patinate::python {

namespace py = pybind11;

py::object object_of(const Json& json) {
  switch (json.type()) {
    case Json::value_t::boolean:
      return py::bool_(json.get<bool>());
    case Json::value_t::number_integer:
      return py::int_(json.get<std::int64_t>());
    case Json::value_t::number_unsigned:
      return py::int_(json.get<std::uint64_t>());
    case Json::value_t::number_float:
      return py::float_(json.get<double>());
    case Json::value_t::string:
      return py::str(json.get<std::string>());
    case Json::value_t::array: {
      py::list list;
      for (const Json& item : json) list.append(object_of(item));
      return list;
    }
    case Json::value_t::object: {
      py::dict dict;
      for (const auto& [key, value] : json.items()) dict[py::str(key)] = object_of(value);
      return dict;
    }
    default:
      return py::none();
  }
}

Json json_from(const py::object& object, const std::string& what) {
  // Python's own module refuses what is no JSON, circles too.
  try {
    const py::object text = py::module_::import("json").attr("dumps")(object, py::arg("allow_nan") = false);
    return Json::parse(py::cast<std::string>(text));
  } catch (const Json::exception& e) {  // A number that no double holds, half a surrogate pair.
    throw InvalidInput(what + ": is no JSON: " + e.what());
  } catch (const py::error_already_set& e) {
    if (!e.matches(PyExc_TypeError) && !e.matches(PyExc_ValueError) && !e.matches(PyExc_RecursionError)) throw;
    throw InvalidInput(what + ": is no JSON: " + std::string(py::str(e.value())));
  }
}

}  // namespace patinate::python
