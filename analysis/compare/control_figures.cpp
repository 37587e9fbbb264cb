#include "analysis/compare/control_figures.h"

#include <cmath>

#include "analysis/compare/sections.h"
#include "analysis/figures/aging.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kMaxTimes = 5, kMaxSamples = 1024;  ///< Times and places of a bin, evenly picked.
constexpr double kAnyVisible = 1.0;  ///< Threshold of texel_aging(), whose change does not depend on it.

}  // namespace

ClassedSurface::ClassedSurface(const ColorStack& stack, std::span<const std::uint16_t> block_of,
                               std::vector<float> values, const ControlFacts& parameter, const SharedControl& shared,
                               int num_classes, std::uint64_t seed, const RunControl& control)
    : stack_(stack),
      block_of_(block_of),
      values_(std::move(values)),
      class_of_(control_classes(values_, parameter, shared, num_classes)) {
  if (stack.num_times() > 1) change_ = texel_aging(stack, kAnyVisible, control).change;
  for (int k = 0; k < num_classes; ++k) {
    std::vector<std::uint32_t> texels;
    for (std::size_t i = 0; i < class_of_.size(); ++i) {
      if (class_of_[i] == k) texels.push_back(static_cast<std::uint32_t>(i));
    }
    colors_.emplace_back();
    for (const std::size_t t : spread_indices(stack.num_times(), kMaxTimes))
      colors_.back().emplace_back(stack, t, texels, block_of_, kMaxSamples, seed);
  }
}

std::vector<std::optional<double>> ClassedSurface::rates(std::span<const int> weights) const {
  std::vector<double> sum(num_classes()), count(num_classes());
  for (std::size_t i = 0; i < class_of_.size(); ++i) {
    if (class_of_[i] < 0) continue;
    const double w = weights[block_of_[i]];
    sum[class_of_[i]] += w * static_cast<double>(change_[i]);
    count[class_of_[i]] += w;
  }
  const double span = stack_.times.back() - stack_.times.front();
  std::vector<std::optional<double>> out(num_classes());
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (count[k] > 0.0) out[k] = sum[k] / count[k] / span;
  }
  return out;
}

std::optional<double> conditional_distance(const ClassedSurface& a, std::span<const int> weights_a,
                                           const ClassedSurface& b, std::span<const int> weights_b) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t k = 0; k < a.num_classes(); ++k) {
    for (std::size_t t = 0; t < a.colors(k).size(); ++t) {
      const std::optional<double> d = sliced_distance(a.colors(k)[t], weights_a, b.colors(k)[t], weights_b);
      if (!d) continue;
      sum += *d;
      ++count;
    }
  }
  return count == 0 ? std::nullopt : std::optional(sum / count);
}

std::optional<double> rate_distance(const ClassedSurface& a, std::span<const int> weights_a, const ClassedSurface& b,
                                    std::span<const int> weights_b) {
  const std::vector<std::optional<double>> x = a.rates(weights_a), y = b.rates(weights_b);
  double sum = 0.0;
  int count = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!x[k] || !y[k]) continue;
    sum += (*x[k] - *y[k]) * (*x[k] - *y[k]);
    ++count;
  }
  return count == 0 ? std::nullopt : std::optional(std::sqrt(sum / count));
}

}  // namespace patinate::analysis
