/// \file
/// Which values the runs of a study take: a grid, a Latin hypercube, or lists side by side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace patinate::cli {

/// Index of a level of each of several factors, every combination once; the last factor changes fastest.
/// @param num_levels  Each > 0.
[[nodiscard]] std::vector<std::vector<std::size_t>> grid_design(const std::vector<std::size_t>& num_levels);

/// Points in the unit cube, of which each of `num_samples` equal slices of every axis holds exactly one
/// [McKay, Beckman, Conover 1979]. Equal seeds give equal points.
/// @returns num_samples points of num_factors coordinates in [0, 1).
[[nodiscard]] std::vector<std::vector<double>> latin_hypercube(std::size_t num_samples, std::size_t num_factors,
                                                               std::uint64_t seed);

}  // namespace patinate::cli
