/// \file
/// A model of aging whose truth is known: a plate that turns green, the sooner the farther right, in closed form.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/fit/fit_job.h"

namespace patinate::testing_support {

/// Frames of 24 x 16 at 0, 1, ..., 8 days; share(x, t) = 1 - exp(-rate t (0.5 + x / 23)) of the way from brown to green
/// of a strength, and a control "x".
/// @param values  rate, strength, idle (does nothing).
[[nodiscard]] analysis::AgedSurface green_plate(const std::vector<double>& values);

/// rate in [0.02, 2] (log) and strength in [0, 1] (a look), idle in [0, 10]; starts 0.1, 0.3, 5. `age` counts its calls
/// in `num_agings` when given. Another seed adds chance of about `chance` to the rate.
[[nodiscard]] analysis::FitTask green_task(const std::filesystem::path& history, double chance = 0.0,
                                           int* num_agings = nullptr);

inline const std::vector<double> kGreenTruth{0.4, 0.8, 7.0};

}  // namespace patinate::testing_support
