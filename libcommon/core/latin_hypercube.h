/// \file
/// Points that fill a cube evenly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace patinate {

/// Points in the unit cube, of which each of `num_samples` equal slices of every axis holds exactly one
/// [McKay, Beckman, Conover 1979]. Equal seeds give equal points.
/// @returns num_samples points of num_factors coordinates in [0, 1).
[[nodiscard]] std::vector<std::vector<double>> latin_hypercube(std::size_t num_samples, std::size_t num_factors,
                                                               std::uint64_t seed);

/// From `num_tries` Latin hypercubes, the one whose nearest two points are farthest apart [Johnson, Moore, Ylvisaker
/// 1990].
/// @param num_tries  >= 1.
[[nodiscard]] std::vector<std::vector<double>> spread_latin_hypercube(std::size_t num_samples, std::size_t num_factors,
                                                                      std::uint64_t seed, int num_tries = 64);

}  // namespace patinate
