/// \file
/// Times of a history given on the command line.
#pragma once

#include <vector>

#include "app/request/times_choice.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

struct TimesArgument : app::TimesChoice {
  /// --time, --times, --num-times.
  void declare(CommandLine& line);
  using app::TimesChoice::resolve;
  /// Says its notes.
  [[nodiscard]] std::vector<double> resolve(CommandRun& run, const HistoryManifest& history, int default_count) const;
};

}  // namespace patinate::cli
