/// \file
/// Which values the runs of a study take: every combination of some.
#pragma once

#include <cstddef>
#include <vector>

namespace patinate::cli {

/// Index of a level of each of several factors, every combination once; the last factor changes fastest.
/// @param num_levels  Each > 0.
[[nodiscard]] std::vector<std::vector<std::size_t>> grid_design(const std::vector<std::size_t>& num_levels);

}  // namespace patinate::cli
