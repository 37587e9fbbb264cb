/// \file
/// What chance alone makes of an objective: which values a capture cannot tell apart.
#pragma once

#include <span>

namespace patinate::analysis {

/// The objective up to which values cannot be told from the truth, such that the intervals of `num_numbers` numbers
/// that it bounds hold all true values in nine of ten cases.
///
/// `draws` are objectives between the model and itself, another seed in the place of the capture. An objective whose
/// square is a mean of N independent squares has the variance f^2 / (2 N), so that draws tell N, and that of fitting N
/// such places rises by f^2 / N where a number is off by its standard deviation. So f^2 may rise above the best's by
/// 2 t^2 var(draws), t Student's for n - 1 degrees of freedom and each number's 0.9^(1 / num_numbers), both sides. Best
/// and truth are compared with one capture: its chance, and what the model lacks, are in both.
/// @returns at least `best`; of fewer than three draws their largest more than it, without draws 1.01 `best`.
/// @throws InvalidInput if `num_numbers` < 1.
[[nodiscard]] double untellable_objective(double best, std::span<const double> draws, int num_numbers);

}  // namespace patinate::analysis
