#include "analysis/explanation/ranks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace patinate::analysis {

RankedValues::RankedValues(std::span<const double> values) : order_(values.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::uint32_t i, std::uint32_t j) { return values[i] < values[j]; });
  for (std::size_t k = 1; k <= order_.size(); ++k) {
    if (k == order_.size() || values[order_[k]] != values[order_[k - 1]])
      tie_ends_.push_back(static_cast<std::uint32_t>(k));
  }
}

std::vector<double> RankedValues::ranks() const { return ranks(std::vector<int>(order_.size(), 1)); }

std::vector<double> RankedValues::ranks(std::span<const int> weights) const {
  std::vector<double> rank(order_.size());
  double before = 0.0;
  std::size_t begin = 0;
  for (const std::uint32_t end : tie_ends_) {
    double weight = 0.0;
    for (std::size_t k = begin; k < end; ++k) weight += weights[order_[k]];
    const double mean = before + 0.5 * (weight - 1.0);
    for (; begin < end; ++begin) rank[order_[begin]] = mean;
    before += weight;
  }
  return rank;
}

double weighted_correlation(std::span<const double> a, std::span<const double> b, std::span<const int> weights) {
  double n = 0.0, sum_a = 0.0, sum_b = 0.0;
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : double(weights[i]); };
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double w = weight(i);
    n += w, sum_a += w * a[i], sum_b += w * b[i];
  }
  double aa = 0.0, bb = 0.0, ab = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double w = weight(i), x = a[i] - sum_a / n, y = b[i] - sum_b / n;
    aa += w * x * x, bb += w * y * y, ab += w * x * y;
  }
  // Rounding leaves a little of a constant side, which counts as none.
  const bool is_constant = aa <= 1e-18 * sum_a * sum_a / n || bb <= 1e-18 * sum_b * sum_b / n;
  return is_constant ? 0.0 : std::clamp(ab / std::sqrt(aa * bb), -1.0, 1.0);
}

}  // namespace patinate::analysis
