/// \file
/// How long stretches of work take.
#pragma once

#include <chrono>

namespace patinate {

/// Adds the seconds of its life to a sum.
class Stopwatch {
 public:
  /// @param sum  Seconds; must outlive it.
  explicit Stopwatch(double& sum) : sum_(sum) {}
  ~Stopwatch() { sum_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& sum_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace patinate
