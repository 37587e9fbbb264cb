/// \file
/// What never changes: a copy of it is the object itself.
#pragma once

#include <pybind11/pybind11.h>

namespace patinate::python {

template <class Class>
void define_copies(Class& type) {
  type.def("__copy__", [](const pybind11::object& self) { return self; });
  type.def("__deepcopy__", [](const pybind11::object& self, const pybind11::object&) { return self; });
}

}  // namespace patinate::python
