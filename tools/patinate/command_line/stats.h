/// \file
/// What a history's frames say in numbers (`patinate info --stats`).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

struct StatsArgument {
  bool is_asked = false;
  std::vector<std::string> classes;  ///< "NAME=#RRGGBB"
  std::filesystem::path csv;
  void declare(CommandLine& line);
};

/// @returns the command's exit code.
int report_stats(CommandRun& run, const StatsArgument& stats, const std::filesystem::path& subject);

}  // namespace patinate::cli
