/// \file
/// Which times of a history are asked for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patinate/history/history.h"

namespace patinate::app {

struct TimesChoice {
  std::optional<double> time;
  std::vector<double> times;
  std::optional<double> count;  ///< [1, 10000], evenly from the first frame to the last.

  [[nodiscard]] bool is_given() const { return time || !times.empty() || count; }
  /// @throws UsageError if several are given, a time twice, or a count that is out of range.
  void check() const;
  /// Times that were asked for; `default_count` times, evenly from the first frame to the last, when nothing was (0 =
  /// every frame's).
  /// @param notes  Gets a line for each time that lies outside the history, whose end is then used.
  /// @throws as check().
  [[nodiscard]] std::vector<double> resolve(const HistoryManifest& history, int default_count,
                                            std::vector<std::string>& notes) const;
};

/// "12.5 d", as `info` says them; different times have different labels.
[[nodiscard]] std::vector<std::string> time_labels(const std::vector<double>& times, TimeUnit unit);

}  // namespace patinate::app
