#include "analysis/fit/chance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr double kNormal90 = 1.2815515655446004;
constexpr std::size_t kFewestDraws = 3;
constexpr double kWithoutDraws = 1.01;

double mean_of(std::span<const double> v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

/// Of Student's distribution, by its expansion around the normal one [Abramowitz, Stegun 26.7.5].
double student90(double freedom) {
  const double z = kNormal90, z2 = z * z;
  const double g1 = (z2 + 1.0) * z / 4.0, g2 = ((5.0 * z2 + 16.0) * z2 + 3.0) * z / 96.0,
               g3 = (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) * z / 384.0;
  return z + g1 / freedom + g2 / (freedom * freedom) + g3 / (freedom * freedom * freedom);
}

}  // namespace

double prediction_bound(std::span<const double> draws) {
  if (draws.empty()) throw InvalidInput("prediction bound: there are no draws");
  if (draws.size() < kFewestDraws) return 2.0 * *std::max_element(draws.begin(), draws.end());
  const auto n = static_cast<double>(draws.size());
  const double mean = mean_of(draws);
  double squares = 0.0;
  for (const double d : draws) squares += (d - mean) * (d - mean);
  return mean + student90(n - 1.0) * std::sqrt(squares / (n - 1.0) * (1.0 + 1.0 / n));
}

double untellable_objective(double best, std::span<const double> draws) {
  if (draws.empty()) return kWithoutDraws * best;
  const double bound = prediction_bound(draws), mean = mean_of(draws);
  return std::max(best, std::sqrt(bound * bound + std::max(0.0, best * best - mean * mean)));
}

}  // namespace patinate::analysis
