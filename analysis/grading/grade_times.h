/// \file
/// When a figure passes the limits of a scale, from photographs at single times.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "analysis/grading/grade_rules.h"
#include "analysis/grading/graded_figure.h"

namespace patinate::analysis {

enum class Reached {
  Reached,
  NotReached,   ///< Not by the last photograph.
  BeforeFirst,  ///< The first photograph shows it.
  NotResolved,  ///< The photographs cannot show so little.
  Forecast,     ///< After the last photograph, as the figure is forecast.
};
inline constexpr std::array<std::string_view, 5> kReachedNames{"reached", "not reached", "before the first photograph",
                                                               "not resolved", "forecast"};

/// A grade's time. `earliest` and `latest` hold it in about 90 of 100 cases; what is missing is not known.
struct GradeTime {
  std::size_t grade = 0;  ///< Index into the scale's.
  Reached state = Reached::NotReached;
  std::optional<double> time = {}, earliest = {}, latest = {};
};

/// Times of all grades but the first. Between two photographs the figure rises linearly.
/// @param figures  By time; those that are missing are passed over. @param least  The least value that can be seen.
/// @param last_seen  Of the last photograph; what is reached later is forecast.
[[nodiscard]] std::vector<GradeTime> grade_times(const GradeScale& scale, std::span<const double> times,
                                                 std::span<const std::optional<GradedFigure>> figures, double least,
                                                 double last_seen);

/// The figure at any time within the series, linear between photographs; nothing outside.
[[nodiscard]] std::optional<GradedFigure> figure_at(std::span<const double> times,
                                                    std::span<const std::optional<GradedFigure>> figures, double time);

}  // namespace patinate::analysis
