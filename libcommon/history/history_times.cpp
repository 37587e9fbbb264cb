#include "libcommon/history/history_times.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"

namespace patinate {

std::optional<TimeProblem> find_time_problem(std::span<const double> times) {
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i])) return TimeProblem{i, "its time is not a number"};
    if (!(std::abs(times[i]) <= kFarthestTime))
      return TimeProblem{i, "has time " + number_text(times[i]) + "; use -1e18 to 1e18"};
    if (i > 0 && !(times[i - 1] < times[i])) {
      return TimeProblem{i, "has time " + number_text(times[i]) + ", not later than " + number_text(times[i - 1]) +
                                ", the one before; times must be strictly increasing"};
    }
  }
  const double span = times.empty() ? 0.0 : times.back() - times.front(), least = kMinTimeStep * std::max(1.0, span);
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] - times[i - 1] >= least) continue;
    return TimeProblem{i, "has time " + number_text(times[i]) + ", nearly that of the one before (" +
                              number_text(times[i - 1]) + "); times must be " + short_number_text(least) +
                              " apart at least" + (span > 1.0 ? ", 1e-12 of their span" : "")};
  }
  return std::nullopt;
}

}  // namespace patinate
