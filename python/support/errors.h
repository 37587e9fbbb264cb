/// \file
/// patinate's errors as Python exceptions, with the same one line.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

namespace patinate::python {

/// Adds Error, InputError (also a ValueError), InvalidInput, ParseError, IoError, CannotComplete and Canceled, as
/// error.h has them, and lets C++ exceptions become these: a cast of a value of another type TypeError, what the file
/// system refuses CannotComplete.
void bind_errors(pybind11::module_& module);

/// Options of a command line as keywords: "--force" is "force=True", "--texel-size" is "texel_size".
[[nodiscard]] std::string with_keywords(const std::string& text);

/// Makes a UserWarning of each: what a command says as a note. @throws what the filter of warnings makes of it
void warn_of(const std::vector<std::string>& notes);

}  // namespace patinate::python
