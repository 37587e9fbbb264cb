/// \file
/// What work says to whoever asked for it.
#pragma once

#include <functional>
#include <string>

#include "patinate/core/run_control.h"

namespace patinate::app {

/// All but `phase` may be called on any thread.
struct Words {
  std::function<void(const std::string& text)> detail = [](const std::string&) {};  ///< For --verbose.
  std::function<void(const std::string& text)> note = [](const std::string&) {};    ///< Receives notes for everyone.
  /// Receives warnings that the result may be wrong.
  std::function<void(const std::string& text)> warning = [](const std::string&) {};
  /// Receives the choice for an option that was not given, or was given as `auto`: for run.json.
  std::function<void(const std::string& option, const std::string& value)> decided = [](const auto&, const auto&) {};
  /// Progress of a part of the work, and a way to stop it.
  std::function<RunControl(const std::string& name)> phase = [](const std::string&) { return RunControl(); };
  bool is_dry_run = false;  ///< Devices are not opened.
};

}  // namespace patinate::app
