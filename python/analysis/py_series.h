/// \file
/// What is compared with something else, where it is in memory.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <string>

#include "patinate/analysis/texture_series.h"

namespace patinate::python {

/// A History or an AgedMesh; nothing for anything else.
[[nodiscard]] std::optional<analysis::TextureSeries> series_in_memory(const pybind11::object& given);

/// Takes a series, or the path of a history or transfer. @throws TypeError, IoError
[[nodiscard]] analysis::TextureSeries series_from(const std::string& function, const char* name,
                                                  const pybind11::object& given);

}  // namespace patinate::python
