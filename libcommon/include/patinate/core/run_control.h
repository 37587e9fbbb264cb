/// \file
/// Progress, canceling and the number of threads: the last parameter of every call that can pass a second.
#pragma once

#include <functional>
#include <stop_token>

#include "patinate/core/error.h"

namespace patinate {

struct RunControl {
  /// Called with fractions that never fall and end at exactly 1; from one thread at a time. May be empty.
  std::function<void(double)> on_progress;
  std::stop_token stop;  ///< Looked at often; at least between chunks of work.
  int num_threads = 0;   ///< 0 = one per processor. Never changes a result.

  void throw_if_stopped() const {
    if (stop.stop_requested()) throw Canceled();
  }
  void report(double fraction) const {
    if (on_progress) on_progress(fraction);
  }
  /// The same control with progress mapped to [begin, end] of this one's.
  [[nodiscard]] RunControl part(double begin, double end) const {
    RunControl inner = *this;
    if (on_progress) {
      inner.on_progress = [outer = on_progress, begin, end](double f) { outer(begin + f * (end - begin)); };
    }
    return inner;
  }
  /// The same control that reports nothing: for parts of a step that reports as a whole.
  [[nodiscard]] RunControl silent() const { return {.on_progress = {}, .stop = stop, .num_threads = num_threads}; }
};

}  // namespace patinate
