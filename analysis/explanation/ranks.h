/// \file
/// Ranks of values that count several times, without sorting again for every set of weights.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace patinate::analysis {

/// A list sorted once. Equal values share the mean of their ranks.
class RankedValues {
 public:
  /// @param values  Finite.
  explicit RankedValues(std::span<const double> values);

  [[nodiscard]] std::size_t size() const { return order_.size(); }
  /// [0, size - 1].
  [[nodiscard]] std::vector<double> ranks() const;
  /// Ranks as if each value stood in the list as often as its weight says. @param weights  >= 0, as many as values.
  [[nodiscard]] std::vector<double> ranks(std::span<const int> weights) const;

 private:
  std::vector<std::uint32_t> order_;
  std::vector<std::uint32_t> tie_ends_;  ///< Into order_, one a group of equal values: where it ends.
};

/// Linear correlation in [-1, 1] of lists whose elements count `weights` times; 0 when either side is constant.
/// @param weights  Empty: each counts once.
[[nodiscard]] double weighted_correlation(std::span<const double> a, std::span<const double> b,
                                          std::span<const int> weights = {});

}  // namespace patinate::analysis
