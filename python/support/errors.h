/// \file
/// patinate's errors as Python exceptions, with the same one line.
#pragma once

#include <pybind11/pybind11.h>

namespace patinate::python {

/// Adds Error, InputError (also a ValueError), InvalidInput, ParseError, IoError, CannotComplete and Canceled, as
/// error.h has them, and lets C++ exceptions become these: a cast of a value of another type TypeError, what the file
/// system refuses CannotComplete.
void bind_errors(pybind11::module_& module);

}  // namespace patinate::python
