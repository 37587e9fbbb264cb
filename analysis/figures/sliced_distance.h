/// \file
/// Distance between distributions of colors.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "analysis/figures/block_values.h"
#include "analysis/figures/color_stack.h"

namespace patinate::analysis {

/// The 15 two-fold axes of the icosahedron; the first three are L*, a* and b* themselves. For every vector v the mean
/// of (v . axis)^2 is exactly |v|^2 / 3.
[[nodiscard]] const std::array<std::array<double, 3>, 15>& sliced_axes();

/// A sample of colors, sorted along every axis once, so that it can be weighted again cheaply.
class SortedColors {
 public:
  /// At most `most` of the texels, spread evenly over the list by (seed, index). @param texels  Indices into the
  /// stack's texels.
  /// @param block_of  Of every texel of the stack.
  SortedColors(const ColorStack& stack, std::size_t time, std::span<const std::uint32_t> texels,
               std::span<const std::uint16_t> block_of, std::size_t most, std::uint64_t seed);

  [[nodiscard]] const std::vector<BlockValue>& along(std::size_t axis) const { return sorted_[axis]; }

 private:
  std::array<std::vector<BlockValue>, 15> sorted_;
};

/// Sliced 2-Wasserstein distance [Bonneel et al. 2015] of two color distributions in units of Delta E 1976, times the
/// square root of 3: shifting all colors by d gives exactly |d|.
/// @param weights_a,weights_b  How often each block counts.
/// @returns nothing when a side has no weight. Cost: O(N) for each of the 15 axes.
[[nodiscard]] std::optional<double> sliced_distance(const SortedColors& a, std::span<const int> weights_a,
                                                    const SortedColors& b, std::span<const int> weights_b);

/// Where that distance comes from: how far every texel's color of A moves, along the axes, when the distribution of A
/// becomes that of B. Equal colors move alike, so nothing depends on their places.
/// @returns Delta E 1976, one a texel of A; the mean of the squares is the square of sliced_distance() of all texels.
/// Cost: O(N log N) for each of the 15 axes.
[[nodiscard]] std::vector<float> sliced_moves(const ColorStack& a, std::size_t time_a, const ColorStack& b,
                                              std::size_t time_b);

}  // namespace patinate::analysis
