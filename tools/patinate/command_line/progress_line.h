/// \file
/// Progress on stderr: a bar with time left on a terminal, elsewhere one plain line now and then.
#pragma once

#include <chrono>
#include <string>

#include "libcommon/core/time_left.h"

namespace patinate::cli {

class ProgressLine {
 public:
  explicit ProgressLine(const std::string& label);
  /// Clears the bar.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(double fraction);

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_;
  bool is_terminal_;
  Clock::duration interval_;
  bool is_shown_ = false;
  Clock::time_point begin_ = Clock::now();
  Clock::time_point last_ = begin_;
  TimeLeft left_;
};

}  // namespace patinate::cli
