#include "analysis/figures/block_bootstrap.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"

namespace patinate::analysis {

namespace {

std::vector<int> drawn(const BlockGrid& grid, std::uint64_t seed, std::uint64_t item, std::uint32_t purpose) {
  std::vector<int> weights(grid.num_blocks(), 0);
  RandomStream random(seed, item, purpose);
  const auto n = static_cast<std::uint32_t>(grid.used.size());
  for (std::uint32_t i = 0; i < n; ++i) ++weights[grid.used[random.below(n)]];
  return weights;
}

}  // namespace

std::vector<int> BlockGrid::half(bool is_second) const {
  std::vector<int> weights(num_blocks(), 0);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x)
      weights[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)] =
          ((x + y) % 2 == 1) == is_second;
  }
  return weights;
}

BlockGrid make_blocks(const ColorStack& stack, int blocks) {
  const auto width = static_cast<std::uint32_t>(stack.width);
  std::uint32_t x0 = width, x1 = 0, y0 = static_cast<std::uint32_t>(stack.height), y1 = 0;
  for (std::uint32_t t : stack.texels) {
    x0 = std::min(x0, t % width), x1 = std::max(x1, t % width);
    y0 = std::min(y0, t / width), y1 = std::max(y1, t / width);
  }
  BlockGrid grid{.columns = blocks, .rows = blocks};
  std::vector<bool> is_used(grid.num_blocks());
  const auto b = static_cast<std::uint32_t>(blocks);
  for (std::uint32_t t : stack.texels) {
    const std::uint32_t column = (t % width - x0) * b / (x1 - x0 + 1), row = (t / width - y0) * b / (y1 - y0 + 1);
    grid.block_of.push_back(static_cast<std::uint16_t>(row * b + column));
    is_used[grid.block_of.back()] = true;
  }
  for (std::size_t k = 0; k < is_used.size(); ++k) {
    if (is_used[k]) grid.used.push_back(static_cast<std::uint16_t>(k));
  }
  return grid;
}

namespace {

/// The figure of surfaces made of drawn blocks; empty when there are too few of them.
std::vector<std::vector<double>> resampled(const BlockGrid& a, const BlockGrid& b, const BlockFigure& figure,
                                           const BootstrapOptions& options, const RunControl& control) {
  constexpr std::size_t kMinBlocks = 4;  // Fewer blocks or draws give no interval.
  constexpr int kMinResamples = 10;      // Fewer draws give no interval.
  if (options.resamples < kMinResamples || a.used.size() < kMinBlocks || b.used.size() < kMinBlocks) return {};
  std::vector<std::vector<double>> results(static_cast<std::size_t>(options.resamples));
  parallel_for(options.resamples, 4, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto r = static_cast<std::size_t>(begin); r < static_cast<std::size_t>(end); ++r) {
      const std::vector<int> wa = drawn(a, options.seed, 2 * r, options.purpose);
      results[r] = figure(wa, options.is_paired ? wa : drawn(b, options.seed, 2 * r + 1, options.purpose));
    }
  });
  std::erase_if(results, [](const auto& values) { return values.empty(); });
  if (10 * results.size() < 9 * static_cast<std::size_t>(options.resamples)) return {};
  return results;
}

template <class Value>
std::vector<double> sorted_draws(const std::vector<std::vector<double>>& results, const Value& value) {
  std::vector<double> draws;
  for (const auto& values : results) draws.push_back(value(values));
  std::sort(draws.begin(), draws.end());
  return draws;
}

/// Nearest rank. @param sorted  Not empty.
double quantile_of(const std::vector<double>& sorted, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

}  // namespace

std::optional<std::vector<FigureInterval>> block_intervals(const BlockGrid& a, const BlockGrid& b,
                                                           const std::vector<double>& value, const BlockFigure& figure,
                                                           const BootstrapOptions& options, const RunControl& control) {
  const std::vector<std::vector<double>> results = resampled(a, b, figure, options, control);
  if (results.empty()) return std::nullopt;
  const auto n = static_cast<double>(std::min(a.used.size(), b.used.size()));
  std::vector<FigureInterval> intervals;
  for (std::size_t k = 0; k < value.size(); ++k) {
    const std::vector<double> squares =
        sorted_draws(results, [&](const auto& values) { return values[k] * values[k]; });
    const double v2 = value[k] * value[k];
    const auto end = [&](double share) {
      return std::sqrt(std::max(0.0, v2 - n / (n - 1.0) * (quantile_of(squares, share) - v2)));
    };
    intervals.push_back({std::min(end(0.975), value[k]), std::max(end(0.025), value[k])});
  }
  return intervals;
}

std::optional<std::vector<FigureInterval>> block_ranges(const BlockGrid& a, const BlockGrid& b,
                                                        const std::vector<double>& value, const BlockFigure& figure,
                                                        const BootstrapOptions& options, const RunControl& control) {
  const std::vector<std::vector<double>> results = resampled(a, b, figure, options, control);
  if (results.empty()) return std::nullopt;
  const auto n = static_cast<double>(std::min(a.used.size(), b.used.size()));
  const double widened = std::sqrt(n / (n - 1.0));
  std::vector<FigureInterval> intervals;
  for (std::size_t k = 0; k < value.size(); ++k) {
    const std::vector<double> drawn = sorted_draws(results, [&](const auto& values) { return values[k]; });
    const auto end = [&](double share) { return value[k] + widened * (quantile_of(drawn, share) - value[k]); };
    intervals.push_back({std::min(end(0.025), value[k]), std::max(end(0.975), value[k])});
  }
  return intervals;
}

std::optional<std::vector<double>> block_standard_errors(const BlockGrid& a, const BlockGrid& b,
                                                         const BlockFigure& figure, const BootstrapOptions& options,
                                                         const RunControl& control) {
  const std::vector<std::vector<double>> results = resampled(a, b, figure, options, control);
  if (results.empty()) return std::nullopt;
  std::vector<double> errors(results.front().size());
  for (std::size_t k = 0; k < errors.size(); ++k) {
    double mean = 0.0, sum = 0.0;
    for (const auto& values : results) mean += values[k] / static_cast<double>(results.size());
    for (const auto& values : results) sum += (values[k] - mean) * (values[k] - mean);
    errors[k] = std::sqrt(sum / static_cast<double>(results.size() - 1));
  }
  return errors;
}

}  // namespace patinate::analysis
