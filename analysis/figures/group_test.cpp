#include "analysis/figures/group_test.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::uint32_t kLabelingPurpose = 401;
constexpr double kRounding = 1e-9;  // Sums of equal terms in another order are equal to this share.

double num_labelings(std::size_t size_a, std::size_t size_b) {
  double count = 1.0;
  for (std::size_t k = 1; k <= size_a; ++k)
    count = std::round(count * static_cast<double>(size_b + k) / static_cast<double>(k));
  return count;
}

double mean_square(std::span<const double> distances) {
  double sum = 0.0;
  for (const double d : distances) sum += d * d;
  return distances.empty() ? 0.0 : sum / static_cast<double>(distances.size());
}

/// Mean squared distances within B, between the groups, within A.
std::array<double, 3> mean_squares(std::span<const double> distances, const std::vector<std::uint8_t>& is_a) {
  std::array<double, 3> sum{}, count{};
  std::size_t k = 0;
  for (std::size_t i = 0; i < is_a.size(); ++i) {
    for (std::size_t j = i + 1; j < is_a.size(); ++j, ++k) {
      const auto kind = static_cast<std::size_t>(is_a[i] + is_a[j]);
      sum[kind] += distances[k] * distances[k];
      count[kind] += 1.0;
    }
  }
  for (std::size_t kind = 0; kind < 3; ++kind) sum[kind] /= count[kind];
  return sum;
}

double share_at_least_the_first(std::span<const double> values, double tolerance) {
  const auto hits = std::count_if(values.begin(), values.end(), [&](double v) { return v >= values[0] - tolerance; });
  return static_cast<double>(hits) / static_cast<double>(values.size());
}

}  // namespace

double smallest_permutation_p(std::size_t size_a, std::size_t size_b) {
  return (size_a == size_b ? 2.0 : 1.0) / num_labelings(size_a, size_b);
}

Labelings make_labelings(std::size_t size_a, std::size_t size_b, std::size_t most, std::uint64_t seed) {
  if (size_a < 2 || size_b < 2) throw InvalidInput("labelings: a group needs two members");
  if (most < 2) throw InvalidInput("labelings: expected at least 2");
  Labelings out{.size_a = size_a, .size_b = size_b};
  std::vector<std::uint8_t> is_a(size_a + size_b, 0);
  std::fill_n(is_a.begin(), size_a, std::uint8_t{1});
  out.smallest_p = smallest_permutation_p(size_a, size_b);
  out.is_exact = num_labelings(size_a, size_b) <= static_cast<double>(most);
  if (out.is_exact) {
    do out.is_a.push_back(is_a);
    while (std::prev_permutation(is_a.begin(), is_a.end()));
    return out;
  }
  out.is_a.push_back(is_a);
  out.smallest_p = std::max(out.smallest_p, 1.0 / static_cast<double>(most));
  for (std::size_t draw = 1; draw < most; ++draw) {
    RandomStream random(seed, draw, kLabelingPurpose);
    std::vector<std::uint8_t> drawn = is_a;
    for (std::size_t k = drawn.size(); k > 1; --k)
      std::swap(drawn[k - 1], drawn[random.below(static_cast<std::uint32_t>(k))]);
    out.is_a.push_back(std::move(drawn));
  }
  return out;
}

std::size_t pair_index(std::size_t i, std::size_t j, std::size_t count) {
  return i * count - i * (i + 1) / 2 + j - i - 1;
}

std::vector<double> squared_gaps(std::span<const double> distances, const Labelings& labelings) {
  std::vector<double> gaps;
  gaps.reserve(labelings.is_a.size());
  for (const std::vector<std::uint8_t>& is_a : labelings.is_a) {
    const auto [within_b, between, within_a] = mean_squares(distances, is_a);
    gaps.push_back(between - (within_a + within_b) / 2.0);
  }
  return gaps;
}

GroupDifference group_difference(std::span<const double> distances, const Labelings& labelings,
                                 std::span<const double> gaps) {
  const auto [within_b, between, within_a] = mean_squares(distances, labelings.is_a.front());
  GroupDifference d{.between = std::sqrt(between),
                    .within_a = std::sqrt(within_a),
                    .within_b = std::sqrt(within_b),
                    .gap = std::sqrt(std::max(0.0, gaps[0])),
                    .spread_a = std::sqrt(within_a / 2.0),
                    .spread_b = std::sqrt(within_b / 2.0),
                    .effect = {},
                    .effect_a = {},
                    .effect_b = {}};
  const double free_a = static_cast<double>(labelings.size_a - 1), free_b = static_cast<double>(labelings.size_b - 1);
  d.spread = std::sqrt((free_a * within_a + free_b * within_b) / (2.0 * (free_a + free_b)));
  const auto over = [&](double spread) { return spread > 0.0 ? std::optional(d.gap / spread) : std::nullopt; };
  d.effect = over(d.spread);
  d.effect_a = over(d.spread_a);
  d.effect_b = over(d.spread_b);
  d.p = share_at_least_the_first(gaps, kRounding * mean_square(distances));
  return d;
}

double overall_p(std::span<const std::vector<double>> distances, std::span<const std::vector<double>> gaps) {
  std::vector<double> largest;
  for (std::size_t f = 0; f < gaps.size(); ++f) {
    const double scale = mean_square(distances[f]);
    if (!(scale > 0.0)) continue;
    if (largest.empty()) largest.assign(gaps[f].size(), -1e300);
    for (std::size_t k = 0; k < largest.size(); ++k) largest[k] = std::max(largest[k], gaps[f][k] / scale);
  }
  return largest.empty() ? 1.0 : share_at_least_the_first(largest, kRounding);
}

std::vector<double> holm_corrected(std::span<const double> p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) { return p[x] < p[y]; });
  std::vector<double> out(p.size());
  double least = 0.0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    least = std::max(least, std::min(1.0, static_cast<double>(p.size() - k) * p[order[k]]));
    out[order[k]] = least;
  }
  return out;
}

}  // namespace patinate::analysis
