#include "analysis/figures/block_values.h"

#include <algorithm>
#include <cmath>

namespace patinate::analysis {

namespace {

std::int64_t total(std::span<const BlockValue> values, std::span<const int> weights) {
  std::int64_t sum = 0;
  for (const BlockValue& v : values) sum += weights[v.block];
  return sum;
}

}  // namespace

void sort_values(std::vector<BlockValue>& values) {
  std::stable_sort(values.begin(), values.end(),
                   [](const BlockValue& a, const BlockValue& b) { return a.value < b.value; });
}

std::optional<double> quantile_distance(std::span<const BlockValue> a, std::span<const int> weights_a,
                                        std::span<const BlockValue> b, std::span<const int> weights_b, int power) {
  const std::int64_t total_a = total(a, weights_a), total_b = total(b, weights_b);
  if (total_a == 0 || total_b == 0) return std::nullopt;
  // Masses in units of 1 / (total_a total_b), exact as integers.
  double sum = 0.0;
  std::size_t i = 0, j = 0;
  std::int64_t left_a = weights_a[a[0].block] * total_b, left_b = weights_b[b[0].block] * total_a;
  while (i < a.size() && j < b.size()) {
    const std::int64_t mass = std::min(left_a, left_b);
    const double d = std::abs(static_cast<double>(a[i].value) - static_cast<double>(b[j].value));
    sum += static_cast<double>(mass) * (power == 2 ? d * d : d);
    left_a -= mass;
    left_b -= mass;
    if (left_a == 0 && ++i < a.size()) left_a = weights_a[a[i].block] * total_b;
    if (left_b == 0 && ++j < b.size()) left_b = weights_b[b[j].block] * total_a;
  }
  return sum / (static_cast<double>(total_a) * static_cast<double>(total_b));
}

std::optional<double> quantile(std::span<const BlockValue> sorted, std::span<const int> weights, double share) {
  const std::int64_t all = total(sorted, weights);
  if (all == 0) return std::nullopt;
  const auto rank = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(share * static_cast<double>(all))));
  std::int64_t sum = 0;
  for (const BlockValue& v : sorted) {
    sum += weights[v.block];
    if (sum >= rank) return static_cast<double>(v.value);
  }
  return static_cast<double>(sorted.back().value);
}

}  // namespace patinate::analysis
