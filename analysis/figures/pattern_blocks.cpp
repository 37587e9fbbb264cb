#include "analysis/figures/pattern_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/figures/block_bootstrap.h"
#include "analysis/figures/spatial.h"

namespace patinate::analysis {

namespace {

constexpr int kCoarse = 4;               ///< Pixels a side of the means that show no grain.
constexpr int kMinCoarseSide = 16;       ///< Least coarse side of a surface of such means: smaller ones say nothing.
constexpr double kFeaturesABlock = 4.0;  ///< See docs/algorithms/compare.md.
constexpr int kFewest = 3, kMost = 8;    ///< Blocks along a side (docs/algorithms/compare.md).

/// One channel of what has changed, as lightness of a stack of one time.
ColorStack change_of(const ColorStack& stack) {
  const std::size_t n = stack.num_texels(), last = stack.num_times() - 1;
  const auto change = [&](std::size_t i, std::size_t c) {
    const float now = stack.lab_of(last, i)[c];
    return last == 0 ? now : now - stack.lab_of(0, i)[c];
  };
  std::array<double, 3> variance{};
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const auto v = static_cast<double>(change(i, c));
      sum += v;
      squares += v * v;
    }
    variance[c] = squares / static_cast<double>(n) - std::pow(sum / static_cast<double>(n), 2);
  }
  const auto channel = static_cast<std::size_t>(std::max_element(variance.begin(), variance.end()) - variance.begin());
  ColorStack out;
  out.width = stack.width;
  out.height = stack.height;
  out.times = {0.0};
  out.texels = stack.texels;
  for (std::size_t i = 0; i < n; ++i) out.lab.insert(out.lab.end(), {change(i, channel), 0.0f, 0.0f});
  return out;
}

/// Means of cells of which at least half is on the surface.
ColorStack coarsened(const ColorStack& stack) {
  ColorStack out;
  out.width = (stack.width + kCoarse - 1) / kCoarse;
  out.height = (stack.height + kCoarse - 1) / kCoarse;
  out.times = {0.0};
  std::vector<float> sums(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  std::vector<int> counts(sums.size());
  for (std::size_t i = 0; i < stack.num_texels(); ++i) {
    const std::size_t x = stack.texels[i] % static_cast<std::uint32_t>(stack.width) / kCoarse,
                      y = stack.texels[i] / static_cast<std::uint32_t>(stack.width) / kCoarse;
    sums[y * static_cast<std::size_t>(out.width) + x] += stack.lab[3 * i];
    ++counts[y * static_cast<std::size_t>(out.width) + x];
  }
  for (std::size_t k = 0; k < sums.size(); ++k) {
    if (2 * counts[k] < kCoarse * kCoarse) continue;
    out.texels.push_back(static_cast<std::uint32_t>(k));
    out.lab.insert(out.lab.end(), {sums[k] / static_cast<float>(counts[k]), 0.0f, 0.0f});
  }
  return out;
}

bool varies(const ColorStack& stack) {
  for (std::size_t i = 1; i < stack.num_texels(); ++i) {
    if (stack.lab[3 * i] != stack.lab[0]) return true;
  }
  return false;
}

/// 1/e length; a third of the shorter side where it does not fall so far.
double length_of(const ColorStack& change) {
  const BlockGrid whole = make_blocks(change, 1);
  return SpatialStructure(change, 0, whole)
      .correlation_length(whole.all())
      .value_or(std::min(change.width, change.height) / 3.0);
}

}  // namespace

std::optional<double> feature_px(const ColorStack& stack) {
  const ColorStack change = change_of(stack);
  if (!varies(change)) return std::nullopt;
  double length = length_of(change);
  const ColorStack coarse = coarsened(change);
  if (std::min(coarse.width, coarse.height) >= kMinCoarseSide && varies(coarse))
    length = std::max(length, kCoarse * length_of(coarse));
  return length;
}

int pattern_blocks(const ColorStack& stack) {
  const std::optional<double> feature = feature_px(stack);
  if (!feature) return kMost;
  const double side = std::min(stack.width, stack.height);
  return std::clamp(static_cast<int>(side / (kFeaturesABlock * *feature)), kFewest, kMost);
}

}  // namespace patinate::analysis
