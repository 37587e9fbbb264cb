/// \file
/// The curve of a factorization as a spline: what decides at one clock, and curves through values.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "patinate/analysis/factorization.h"

namespace patinate::analysis {

/// The four coefficients that decide at one clock, and by how much.
struct CurveBasis {
  std::size_t first = 0;
  std::array<double, 4> weights = {};  ///< Sum 1.
  std::array<double, 4> slopes = {};   ///< Slopes of the weights, per clock; 0 beyond the ends.
};
[[nodiscard]] CurveBasis curve_basis(const TemporalCurve& curve, double clock);

/// Least squares through values at clocks, with so little resistance to bending that only stretches without a value
/// feel it.
/// @param low,high  low < high. @param num_intervals  >= 1. @param clocks,values  As many; not empty.
/// @returns the coefficients of one channel.
[[nodiscard]] std::vector<double> fitted_curve(double low, double high, int num_intervals,
                                               std::span<const double> clocks, std::span<const double> values);

/// Moves the curve (as nearly as its intervals allow) to another domain.
[[nodiscard]] TemporalCurve moved_curve(const TemporalCurve& curve, double low, double high, int num_intervals);

}  // namespace patinate::analysis
