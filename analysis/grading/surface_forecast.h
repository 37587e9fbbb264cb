/// \file
/// Figures of damage that does not heal, and what becomes of figures after the last photograph.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "analysis/grading/graded_surface.h"

namespace patinate::analysis {

/// Rust, creep and flaking do not heal: their figures never fall, nor do the ends of their intervals.
void keep_from_falling(GradedRegion& region);

/// Forecasts all figures that change. @throws InvalidInput if `until` is not after the last photograph.
void add_forecasts(double until, GradedSurface& surface);

/// A figure at the times of photographs, and then at those of its forecast if it has one.
struct ExtendedSeries {
  std::vector<double> times;
  std::vector<std::optional<GradedFigure>> figures;
};
[[nodiscard]] ExtendedSeries extended_series(const GradedSurface& surface, const GradedRegion& region,
                                             std::string_view figure);

}  // namespace patinate::analysis
