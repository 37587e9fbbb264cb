/// \file
/// One curve per channel over a clock that all places share.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace patinate::analysis {

/// Uniform cubic B-splines [de Boor 1978] on [low, high], one per channel; beyond the ends the values at the ends hold.
struct TemporalCurve {
  double low = 0.0, high = 1.0;                        ///< Of the clock; low < high.
  std::vector<std::vector<double>> coefficients = {};  ///< For every channel num_intervals() + 3.

  [[nodiscard]] int num_channels() const { return static_cast<int>(coefficients.size()); }
  [[nodiscard]] int num_intervals() const { return static_cast<int>(coefficients.front().size()) - 3; }
  [[nodiscard]] double value(int channel, double clock) const;
  /// Values from equally spaced clocks, both ends among them; >= 2.
  [[nodiscard]] std::vector<double> samples(int channel, int count) const;
};

/// The four coefficients that decide at one clock, and by how much.
struct CurveBasis {
  std::size_t first = 0;
  std::array<double, 4> weights = {};  ///< Sum 1.
  std::array<double, 4> slopes = {};   ///< Of the weights, per clock; 0 beyond the ends.
};
[[nodiscard]] CurveBasis curve_basis(const TemporalCurve& curve, double clock);

/// Least squares through values at clocks, with so little resistance to bending that only stretches without a value
/// feel it.
/// @param low,high  low < high. @param num_intervals  >= 1. @param clocks,values  As many; not empty.
/// @returns the coefficients of one channel.
[[nodiscard]] std::vector<double> fitted_curve(double low, double high, int num_intervals,
                                               std::span<const double> clocks, std::span<const double> values);

/// The same curve (as nearly as its intervals allow) on another domain.
[[nodiscard]] TemporalCurve moved_curve(const TemporalCurve& curve, double low, double high, int num_intervals);

}  // namespace patinate::analysis
