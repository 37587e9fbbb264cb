/// \file
/// Color curves of a history or transfer as CSV (`patinate info --curves`).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

struct CurvesArgument {
  std::filesystem::path file;   ///< "" = no curves.
  std::string by;               ///< A control of the history; "" = the whole surface.
  std::optional<double> bins;   ///< Of `by`; 5.
  std::vector<std::string> at;  ///< "x,y"
  void declare(CommandLine& line);
};

/// Writes the CSV: a row for each frame and region. `pixels` of a transfer are its texels.
/// @returns the command's exit code.
int write_curves(CommandRun& run, const CurvesArgument& curves, const std::filesystem::path& subject);

}  // namespace patinate::cli
