/// \file
/// The curve and the clocks of some places, all at once.
#pragma once

#include <vector>

#include "patinate/analysis/factorization.h"

namespace patinate::analysis {

/// Minimizes the same robust sum as PlaceFit over the curve as well (Ceres, each place eliminated): gives `model.curve`
/// and `factors` new values. The domain of the curve stays.
/// @throws Canceled
/// @param places   Their times are those of `factors`' clocks. @param factors  One for each place, all Fitted or Open.
/// @param max_iterations  > 0.
void refine_curve(const PlaceSeries& places, TemporalModel& model, std::vector<PlaceFactors>& factors,
                  int max_iterations, const RunControl& control);

}  // namespace patinate::analysis
