/// \file
/// A surface cut into blocks that are wide enough to count as independent places.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "analysis/figures/block_bootstrap.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"

namespace patinate::analysis {

inline constexpr int kMinBlocks = 24;   ///< With fewer, chance alone reaches high correlations.
inline constexpr int kMaxBlocks = 400;  ///< Memory of BlockShuffles is samples x blocks.

inline constexpr double kRangesInBlock =
    2.5;  ///< Edge of a block: most pairs of places that know of each other share one.

/// Cells around centers that lie as far from each other as can be (farthest-point sampling [Gonzalez 1985]): every
/// sample belongs to the nearest center, in space, whatever chart it lies in.
struct SurfaceBlocks {
  std::vector<std::vector<std::uint32_t>> members;  ///< Samples of each block, ascending; none is empty.
  double edge_mm = 0.0;                             ///< Side of a square of a block's mean area.

  /// Grid for block_standard_errors(). @param num_samples  Of all blocks together.
  [[nodiscard]] BlockGrid grid(std::size_t num_samples) const;
};

/// @param positions_mm  At least `count`, of which as many differ. @param count  > 0. @param area_mm2  Of the surface
/// that they stand for.
[[nodiscard]] SurfaceBlocks make_surface_blocks(std::span<const Vec3> positions_mm, int count, double area_mm2);

/// How many blocks fit whose edge is kRangesInBlock times `range_mm`, within [kMinBlocks, kMaxBlocks].
[[nodiscard]] int suited_block_count(double range_mm, double area_mm2);

inline constexpr std::size_t kNumDistanceSteps = 128;  ///< Steps of the correlation over distance.

/// How alike the values of two places are, by their distance, for one list of values or more.
struct Correlograms {
  double step_mm = 0.0;                                      ///< Pairs of step k lie [k, k + 1) of it apart.
  std::array<std::uint64_t, kNumDistanceSteps> num_pairs{};  ///< Number of pairs of each step.
  std::vector<std::array<double, kNumDistanceSteps>> mean;  ///< For each list: the mean product of standardized values.
  std::size_t num_places = 0;                               ///< That were looked at: at most 2,000.

  /// Where values of a list no longer know of each other: the first step whose mean product is below 0.1; half of the
  /// greatest distance if there is none.
  [[nodiscard]] double range_mm(std::size_t list) const;
  /// Variance of the correlation of two lists that have nothing to do with each other but hang together like these: the
  /// mean over all pairs of places of the product of both correlations [Clifford, Richardson, Hemon 1989].
  /// @param num_samples  That the correlation is of.
  [[nodiscard]] double chance_variance(std::size_t a, std::size_t b, std::size_t num_samples) const;
};

/// @param lists  Each as long as positions. Same bits for any number of threads.
[[nodiscard]] Correlograms correlograms(std::span<const Vec3> positions_mm,
                                        const std::vector<std::vector<double>>& lists, const RunControl& control = {});

}  // namespace patinate::analysis
