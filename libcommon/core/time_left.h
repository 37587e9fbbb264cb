/// \file
/// How long work still takes, judged by its progress.
#pragma once

#include <deque>
#include <optional>

namespace patinate {

/// Estimates from the speed of the last two thirds of the time, and never from what passed before the first progress:
/// opening files and building tables stand at the beginning, cost seconds, and say nothing of the rest.
class TimeLeft {
 public:
  /// @param seconds   Since the work began; never falls.
  /// @param fraction  What is done of it, in [0, 1]; never falls.
  void add(double seconds, double fraction);
  /// In seconds; nothing while there is too little to go by (2 s and 2 % of progress since the first report).
  [[nodiscard]] std::optional<double> seconds() const;

 private:
  struct Report {
    double seconds = 0.0;
    double fraction = 0.0;
  };
  double begin_ = 0.0;          ///< Begin of the first report.
  std::deque<Report> reports_;  ///< Those that progress is measured from: the first is the youngest beyond the window.
};

}  // namespace patinate
