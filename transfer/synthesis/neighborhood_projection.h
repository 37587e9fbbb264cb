/// \file
/// Whole neighborhoods as 16 integers each, which tell how far apart two of them are at least.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "transfer/synthesis/energy.h"
#include "transfer/synthesis/window_kernel.h"

namespace patinate::transfer {

/// A projected neighborhood: |values| < 11,600 each, and in length.
using ProjectedNeighborhood = std::array<std::int16_t, 16>;

/// The appearances around a pixel, in units of 4: projected on their leading principal axes (orthonormal under the
/// neighborhood's weights), and the length of what is left of them. [Fukunaga and Narendra 1975; the length of the
/// rest: Hwang, Han and Ahn 2012]
///
/// For any two lists of appearances a, b and their projections p, q: |p - q|^2 <= reach(sum_k w_k |a_k - b_k|^2); of
/// projections by quarters, so do the values of any quarters for the sum over those. The axes are integers over 2^13,
/// and short enough that no vector grows (by Gershgorin's circles); what follows is rounded down, so that each value is
/// off by less than 1 and the difference of two projections by less than sqrt(16).
class NeighborhoodProjection {
 public:
  enum class Parts {
    Whole,     ///< 15 axes, one rest.
    Quarters,  ///< 3 axes and a rest for each quarter: values 4 q to 4 q + 3.
  };
  /// @param source  With usable pixels.
  NeighborhoodProjection(const SourceLevel& source, const Neighborhood& neighborhood, Parts parts);

  /// @param pixel  Usable.
  [[nodiscard]] ProjectedNeighborhood of_pixel(std::int32_t pixel) const;
  /// @param appearances  In [-kAppearanceLimit, kAppearanceLimit]; of the neighbors in the order of the neighborhood.
  [[nodiscard]] ProjectedNeighborhood of(std::span<const std::int16_t> appearances) const;
  /// The largest |p - q|^2 of projections of neighborhoods that differ by `squares` >= 0. reach(s + 16 x) >= reach(s) +
  /// x.
  [[nodiscard]] static std::int64_t reach(std::int64_t squares) { return window_kernel::projection_reach(squares); }
  static constexpr int kUnit = window_kernel::kProjectionUnit;
  /// Rows as projection_term() takes them: 16 rows, each of as many values as a list of appearances has.
  [[nodiscard]] std::span<const std::int16_t> rows() const { return rows_; }
  static constexpr std::size_t kMaxAppearances = 120 * kAppearanceSize;  ///< Radius 5.

 private:
  struct Part {
    std::size_t first_value = 0, num_axes = 0;  ///< Its rest follows.
    std::vector<std::int16_t> weights;          ///< Weights of the appearances; 0 outside.
  };
  void find_axes(const SourceLevel& source, const Part& part);
  void gather(std::int32_t pixel, std::span<std::int16_t> appearances) const;

  const SourceLevel& source_;
  std::vector<std::int32_t> deltas_;  ///< Deltas of the neighbors, in values.
  std::vector<Part> parts_;
  [[nodiscard]] std::int16_t* row_of(std::size_t value) {
    return rows_.data() + value * deltas_.size() * kAppearanceSize;
  }
  std::vector<std::int16_t> rows_;  ///< One a value: an axis over 2^13, 0 outside of its part; of a rest its weights.
};

}  // namespace patinate::transfer
