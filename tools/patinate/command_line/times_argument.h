/// \file
/// Times of a history given on the command line.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patinate/history/history.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

struct TimesArgument {
  std::optional<double> time;
  std::vector<double> times;
  std::optional<double> count;

  /// --time, --times, --num-times.
  void declare(CommandLine& line);
  [[nodiscard]] bool is_given() const { return time || !times.empty() || count; }
  /// What was asked for; `default_count` times, evenly from the first frame to the last, when nothing was (0 = every
  /// frame's). Says so when a time lies outside the history, whose end is then used.
  /// @throws UsageError if several of the options are given.
  [[nodiscard]] std::vector<double> resolve(CommandRun& run, const HistoryManifest& history, int default_count) const;
};

/// "12.5 d"; different times have different labels.
[[nodiscard]] std::vector<std::string> time_labels(const std::vector<double>& times, TimeUnit unit);

}  // namespace patinate::cli
