/// \file
/// What chance alone makes of an objective: which values a capture cannot tell apart.
#pragma once

#include <span>

namespace patinate::analysis {

/// The value that a normal variable exceeds in one of ten cases, when mean and standard deviation are those of
/// `draws` and one more is drawn: mean + t(0.9, n - 1) sd sqrt(1 + 1 / n). Of fewer than three draws: twice the
/// largest. @throws InvalidInput without draws.
[[nodiscard]] double prediction_bound(std::span<const double> draws);

/// The objective up to which values cannot be told from the truth. `draws` are objectives between the model and itself,
/// another seed in the place of the capture: what the truth itself would have. The capture is one more of them, so the
/// truth lies below their prediction_bound() in nine of ten cases; intervals around all such values hold it oftener.
/// Where the model is wrong the best lies above what chance makes; squares of distances add, so that this much is added
/// to the bound: sqrt(bound^2 + max(0, best^2 - mean^2)).
/// @returns at least `best`; without draws 1.01 `best`.
[[nodiscard]] double untellable_objective(double best, std::span<const double> draws);

}  // namespace patinate::analysis
