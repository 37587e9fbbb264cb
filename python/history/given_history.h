/// \file
/// A history as an argument: an object, or the path of one.
#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <list>
#include <memory>
#include <string>

#include "libcommon/core/temporary_file.h"
#include "patinate/core/run_control.h"
#include "python/history/py_history.h"

namespace patinate::python {

/// Where what is in memory only is saved for the time of a call.
using Rooms = std::list<TemporaryFolder>;

/// A path, or what is in memory only.
struct GivenHistory {
  std::filesystem::path path;
  std::shared_ptr<const History> memory = nullptr;
};
/// @param what  Of the function's parameter. @throws TypeError
[[nodiscard]] GivenHistory given_history(const std::string& function, const std::string& name,
                                         const pybind11::object& given,
                                         const std::string& what = "a History, or the path of one");
/// Its folder, that of `library:NAME` too.
[[nodiscard]] std::filesystem::path place_of(const GivenHistory& history, Rooms& rooms, const RunControl& control);
/// Opened, if it is a path. @throws TypeError, IoError
[[nodiscard]] PyHistory history_from(const std::string& function, const std::string& name,
                                     const pybind11::object& given);

}  // namespace patinate::python
