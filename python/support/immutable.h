/// \file
/// What never changes: a copy of it is the object itself, and equal values are equal objects.
#pragma once

#include <pybind11/pybind11.h>

namespace patinate::python {

template <class Class>
void define_copies(Class& type) {
  type.def("__copy__", [](const pybind11::object& self) { return self; });
  type.def("__deepcopy__", [](const pybind11::object& self, const pybind11::object&) { return self; });
}

/// @param identity  A text of a value that equal values share, and no others.
template <class Value, class Class, class F>
void define_equality(Class& type, F identity) {
  type.def("__eq__", [identity](const Value& self, const pybind11::object& other) -> pybind11::object {
    if (!pybind11::isinstance<Value>(other)) return pybind11::reinterpret_borrow<pybind11::object>(Py_NotImplemented);
    const auto& that = pybind11::cast<const Value&>(other);
    return pybind11::bool_(&self == &that || identity(self) == identity(that));
  });
  type.def("__hash__", [identity](const Value& self) { return pybind11::hash(pybind11::str(identity(self))); });
}

}  // namespace patinate::python
