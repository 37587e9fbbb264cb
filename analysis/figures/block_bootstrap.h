/// \file
/// How certain a figure of a surface is: blocks of it drawn again and again. Neighboring texels are alike, so that
/// texels drawn one by one would promise too much.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "analysis/figures/color_stack.h"

namespace patinate::analysis {

/// A surface cut into a grid of blocks over the bounding box of its texels.
struct BlockGrid {
  int columns = 0;
  int rows = 0;
  std::vector<std::uint16_t> block_of = {};  ///< Block of every texel of the stack: row * columns + column.
  std::vector<std::uint16_t> used = {};      ///< Blocks that hold texels, ascending.

  [[nodiscard]] std::size_t num_blocks() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  /// 1 for all / for the black or white squares of the chess board.
  [[nodiscard]] std::vector<int> all() const { return std::vector<int>(num_blocks(), 1); }
  [[nodiscard]] std::vector<int> half(bool is_second) const;
};
/// @param blocks  Per side, [1, 256].
[[nodiscard]] BlockGrid make_blocks(const ColorStack& stack, int blocks);

/// A figure of two surfaces whose blocks count so many times: one value or a curve; empty when it is not defined.
using BlockFigure =
    std::function<std::vector<double>(const std::vector<int>& weights_a, const std::vector<int>& weights_b)>;

struct BootstrapOptions {
  int resamples = 200;
  std::uint64_t seed = 0;
  std::uint32_t purpose = 0;  ///< Keeps the draws of several figures apart.
  bool is_paired = false;     ///< Draws the same blocks in both surfaces: they show the same places.
};

/// Where a distance lies.
struct FigureInterval {
  double low = 0.0;
  double high = 0.0;
};
/// 95 % intervals of a figure's values that are distances: >= 0, and 0 for equal surfaces. Two samples of one surface
/// are some way apart, and so are two draws of their blocks: what a draw has more than the value, in squares, is what
/// the value has more than the truth. With v the value and q the quantiles of draws' squares, widened by n / (n - 1)
/// for n blocks, low^2 = 2 v^2 - q(0.975), high^2 = 2 v^2 - q(0.025) [basic interval, Davison and Hinkley 1997], not
/// below 0, and v within.
/// @param value  The figure with all blocks. @returns as block_standard_errors().
[[nodiscard]] std::optional<std::vector<FigureInterval>> block_intervals(const BlockGrid& a, const BlockGrid& b,
                                                                         const std::vector<double>& value,
                                                                         const BlockFigure& figure,
                                                                         const BootstrapOptions& options,
                                                                         const RunControl& control = {});

/// 95 % intervals of a figure's values that may lie on either side of what they are: the draws' quantiles, from the
/// value sqrt(n / (n - 1)) times as far for n blocks [percentile interval, Efron 1979]; the value is within.
/// @param value  The figure with all blocks. @returns as block_standard_errors().
[[nodiscard]] std::optional<std::vector<FigureInterval>> block_ranges(const BlockGrid& a, const BlockGrid& b,
                                                                      const std::vector<double>& value,
                                                                      const BlockFigure& figure,
                                                                      const BootstrapOptions& options,
                                                                      const RunControl& control = {});

/// Standard errors of a figure's values [Efron 1979; blocks: Kunsch 1989, Hall 1985]: standard deviations over surfaces
/// made of as many blocks drawn with replacement.
/// @returns nothing with fewer than 4 blocks or 10 resamples, or when the figure is undefined in more than a tenth of
/// them. Same bits for any number of threads.
[[nodiscard]] std::optional<std::vector<double>> block_standard_errors(const BlockGrid& a, const BlockGrid& b,
                                                                       const BlockFigure& figure,
                                                                       const BootstrapOptions& options,
                                                                       const RunControl& control = {});

}  // namespace patinate::analysis
