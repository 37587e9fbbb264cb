/// \file
/// What `info` tells and `validate` checks of a path: one table of kinds.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "tools/patinate/command_line/facts.h"

namespace patinate::cli {

/// Runs checks one after another and keeps the line of each that fails.
class Checks {
 public:
  void run(const std::function<void()>& check);
  [[nodiscard]] const std::vector<std::string>& problems() const { return problems_; }

 private:
  std::vector<std::string> problems_;
};

/// @throws IoError for what is no path of ours or cannot be read; so does check_path().
[[nodiscard]] Facts facts_of(const std::filesystem::path& path);
/// Reads all that belongs to it.
void check_path(const std::filesystem::path& path, Checks& checks, const RunControl& control);
/// The kinds, for help.
[[nodiscard]] std::string path_kinds_text();

}  // namespace patinate::cli
