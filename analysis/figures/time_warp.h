/// \file
/// Two surfaces that show the same places and age at other speeds: the common clock, and every texel's delay.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/figures/block_bootstrap.h"
#include "analysis/figures/color_stack.h"
#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// Colors of a stack between its times, blended; clamped to its ends.
struct StackTime {
  std::size_t index = 0;
  double fraction = 0.0;  ///< [0, 1); towards index + 1.
};
[[nodiscard]] StackTime locate(const std::vector<double>& times, double time);

/// One clock for the whole surface.
struct TimeWarp {
  std::vector<double> times;   ///< Times of A.
  std::vector<double> warped;  ///< Times of B at which it shows what is nearest to A; they never fall.
  std::vector<double> before;  ///< Root mean square Delta E 1976 at equal times.
  std::vector<double> after;   ///< Distance at the warped times.
};
/// The best monotone warp: the path through the matrix of mean squared Delta E 1976 between A's times and `fineness`
/// steps between B's, by dynamic programming [Sakoe and Chiba 1978], with a price for leaving equal times that decides
/// only where nothing else does.
/// @param a,b  The same texels; both stacks' times count alike (B's are A's, or both run from 0 to 1).
/// @throws InvalidInput unless so, or with fewer than two times. Cost: O(T^2 N). Same bits for any number of threads.
[[nodiscard]] TimeWarp find_time_warp(const ColorStack& a, const ColorStack& b, int fineness = 8,
                                      const RunControl& control = {});

/// The warps of surfaces made of blocks of two: how certain the best one is.
class BlockWarps {
 public:
  /// @param blocks  Of the texels of both. @throws InvalidInput as find_time_warp(). Cost: O(T^2 N); memory:
  /// memory_bytes().
  BlockWarps(const ColorStack& a, const ColorStack& b, const BlockGrid& blocks, int fineness = 8,
             const RunControl& control = {});
  /// Where blocks count so many times, at least one of them.
  [[nodiscard]] TimeWarp warp(const std::vector<int>& weights) const;
  [[nodiscard]] static std::int64_t memory_bytes(std::size_t num_times, const BlockGrid& blocks);

 private:
  std::vector<double> times_a_, times_b_;
  int fineness_;
  std::vector<std::uint16_t> used_;
  std::vector<double> num_texels_;  ///< By used block.
  /// Sums over each used block's texels: what any blend of B's times is made of.
  std::vector<double> ab_;    ///< [block][i][j]: |A_i - B_j|^2
  std::vector<double> turn_;  ///< [block][i][j]: (A_i - B_j) . (B_j+1 - B_j)
  std::vector<double> step_;  ///< [block][j]: |B_j+1 - B_j|^2
};

/// How much later B shows what A shows. A list of one entry a texel.
struct TimeShift {
  std::vector<float> shift;            ///< In the stacks' time; > 0: B ages later. 0 where it is not known.
  std::vector<std::uint8_t> is_known;  ///< Both sides change visibly there.
};
/// For every texel the shift s that makes B(t + s) nearest to A(t) in CIELAB over all times, up to half of the span
/// either way, B's first and last color continuing beyond its ends. To a 512th of the span, and between those by a
/// parabola.
/// @param known  1 where both sides age visibly. @throws InvalidInput as find_time_warp().
[[nodiscard]] TimeShift find_time_shift(const ColorStack& a, const ColorStack& b,
                                        const std::vector<std::uint8_t>& known, const RunControl& control = {});

}  // namespace patinate::analysis
