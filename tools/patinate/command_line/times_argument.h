/// \file
/// Times of a history given on the command line.
#pragma once

#include <vector>

#include "tools/patinate/command_line/command_run.h"
#include "tools/patinate/command_line/times_choice.h"

namespace patinate::cli {

struct TimesArgument : TimesChoice {
  /// --time, --times, --num-times.
  void declare(CommandLine& line);
  using TimesChoice::resolve;
  /// Says its notes.
  [[nodiscard]] std::vector<double> resolve(CommandRun& run, const HistoryManifest& history, int default_count) const;
};

}  // namespace patinate::cli
