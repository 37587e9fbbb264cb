/// \file
/// Which times a history may have: so that every span, step and share of them is a number that can be computed with.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "patinate/history/history_value.h"

namespace patinate {

inline constexpr double kFarthestTime =
    1e18;  ///< On either side of 0, in the history's unit: longer than the universe in seconds.
inline constexpr double kMinTimeStep =
    1e-12;  ///< In the history's unit, and as a share of the span from the first to the last time.

struct TimeProblem {
  std::size_t index = 0;  ///< Index of the first time that is wrong.
  std::string text;       ///< "has time 3, not later than 3, the one before; ...".
};
/// Nothing when all are within +-kFarthestTime and each is later than the one before by kMinTimeStep at least.
[[nodiscard]] std::optional<TimeProblem> find_time_problem(std::span<const double> times);

/// The unit as people read it: "yr" for years, which files call "a"; else as time_unit_text().
[[nodiscard]] std::string shown_time_unit(TimeUnit unit);

}  // namespace patinate
