/// \file
/// JSON values as Python's, and back.
#pragma once

#include <pybind11/pybind11.h>

#include "patinate/core/json.h"

namespace patinate::python {

[[nodiscard]] pybind11::object object_of(const Json& json);
/// dict, list, text, number, bool, None; a text that is a path stays a text. @throws InvalidInput, naming `what`.
[[nodiscard]] Json json_from(const pybind11::object& object, const std::string& what);

}  // namespace patinate::python
