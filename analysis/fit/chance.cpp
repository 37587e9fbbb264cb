#include "analysis/fit/chance.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr double kHeldByIntervals = 0.9;  ///< All intervals together (docs/algorithms/fit.md).
constexpr std::size_t kMinDraws = 3;      ///< Fewer draws give no deviation: the largest of them is taken.
constexpr double kWithoutDraws = 1.01;    ///< Rise of the objective by 1 % where no draws were made.

double variance_of(std::span<const double> v) {
  const auto n = static_cast<double>(v.size());
  const double mean = std::accumulate(v.begin(), v.end(), 0.0) / n;
  double squares = 0.0;
  for (const double x : v) squares += (x - mean) * (x - mean);
  return squares / (n - 1.0);
}

}  // namespace

double untellable_objective(double best, std::span<const double> draws, int num_numbers) {
  if (num_numbers < 1) throw InvalidInput("untellable objective: at least one number must be varied");
  if (draws.empty()) return kWithoutDraws * best;
  if (draws.size() < kMinDraws) return best + *std::max_element(draws.begin(), draws.end());
  const double each = std::pow(kHeldByIntervals, 1.0 / num_numbers);
  const double t =
      boost::math::quantile(boost::math::students_t(static_cast<double>(draws.size() - 1)), 0.5 * (1.0 + each));
  return std::sqrt(best * best + 2.0 * t * t * variance_of(draws));
}

}  // namespace patinate::analysis
