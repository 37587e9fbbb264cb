/// \file
/// Numbers of a surface with the block that each belongs to, sorted once and weighted often.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace patinate::analysis {

struct BlockValue {
  float value;
  std::uint16_t block;
};
/// By value; equal ones stay in order.
void sort_values(std::vector<BlockValue>& values);

/// Integral of |difference|^power of two quantile functions: for power 1 the 1-Wasserstein distance, for 2 the square
/// of the 2-Wasserstein distance.
/// @param a,b  Sorted. @param weights_a,weights_b  How often each block counts. @param power  1 or 2.
/// @returns nothing when a side has no weight. Cost: O(N).
[[nodiscard]] std::optional<double> quantile_distance(std::span<const BlockValue> a, std::span<const int> weights_a,
                                                      std::span<const BlockValue> b, std::span<const int> weights_b,
                                                      int power);

/// The value below which a share of the weight lies (nearest rank). @returns nothing without weight.
[[nodiscard]] std::optional<double> quantile(std::span<const BlockValue> sorted, std::span<const int> weights,
                                             double share);

}  // namespace patinate::analysis
