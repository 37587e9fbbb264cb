/// \file
/// Chi-square tests at the 1 % level.
#pragma once

#include <cmath>
#include <span>

namespace patinate::testing_support {

/// Limit of chi-square in 99 of 100 cases [Wilson and Hilferty 1931]. @param n  Degrees of freedom.
[[nodiscard]] inline double chi_square_limit(double n) {
  return n * std::pow(1.0 - 2.0 / (9.0 * n) + 2.326 * std::sqrt(2.0 / (9.0 * n)), 3.0);
}

/// Chi-square of counts that are expected to be equal.
[[nodiscard]] inline double chi_square_of_equal(std::span<const double> counts) {
  double total = 0.0, sum = 0.0;
  for (const double c : counts) total += c;
  const double expected = total / static_cast<double>(counts.size());
  for (const double c : counts) sum += (c - expected) * (c - expected) / expected;
  return sum;
}

}  // namespace patinate::testing_support
