/// \file
/// How far two quantities rise together.
#pragma once

#include <span>

namespace patinate {

/// Spearman's rank correlation in [-1, 1]: the linear correlation of ranks, equal values sharing the mean of theirs.
/// 0 when either side is constant.
/// @throws InvalidInput if the lengths differ, are below 2, or a value is NaN. Cost: O(n log n).
[[nodiscard]] double rank_correlation(std::span<const double> a, std::span<const double> b);

}  // namespace patinate
