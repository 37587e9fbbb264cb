#include "analysis/figures/spatial.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace patinate::analysis {

namespace {

constexpr int kSmallestTile = 8, kLargestTile = 64;  ///< px: sides of a spectrum's tile, powers of two.
/// px of the autocorrelation; directions 0, 45, 90 and 135 degrees.
constexpr std::size_t kMaxLags = 96, kDirections = 4;
constexpr int kStepX[kDirections] = {1, 0, 1, 1}, kStepY[kDirections] = {0, 1, 1, -1};
constexpr double kStepLength[kDirections] = {1.0, 1.0, std::numbers::sqrt2, std::numbers::sqrt2};

using Complex = std::complex<double>;

/// Radix-2 transform of n values that lie `step` apart. @param n  A power of two.
void transform(Complex* values, std::size_t n, std::size_t step) {
  for (std::size_t i = 1, j = 0; i < n; ++i) {
    std::size_t bit = n >> 1;
    for (; (j & bit) != 0; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(values[i * step], values[j * step]);
  }
  for (std::size_t half = 1; half < n; half *= 2) {
    for (std::size_t k = 0; k < half; ++k) {
      const double angle = -std::numbers::pi * static_cast<double>(k) / static_cast<double>(half);
      const Complex turn(std::cos(angle), std::sin(angle));
      for (std::size_t i = k; i < n; i += 2 * half) {
        const Complex odd = turn * values[(i + half) * step], even = values[i * step];
        values[i * step] = even + odd;
        values[(i + half) * step] = even - odd;
      }
    }
  }
}

/// Ring of a frequency of (u, v) cycles per tile: half octaves from 1 on; -1 for the mean and what lies beyond the
/// Nyquist frequency.
int ring_of(double u, double v, int tile) {
  const double r = std::hypot(u, v);
  if (r < 1.0 || r >= tile / 2.0) return -1;
  return static_cast<int>(std::floor(2.0 * std::log2(r) + 1e-9));
}

}  // namespace

SpatialStructure::SpatialStructure(const ColorStack& stack, std::size_t time, const BlockGrid& grid,
                                   SpatialFigures figures) {
  const int shorter = std::min(stack.width, stack.height);
  tile_px_ = kLargestTile;
  while (tile_px_ > kSmallestTile && tile_px_ > shorter / 4) tile_px_ /= 2;
  const ImageF values = stack.lab_image(time, 0);
  const ImageU8 mask = stack.mask();
  add_tiles(stack, values, mask, grid);
  if (figures == SpatialFigures::Spectrum) return;
  num_lags_ = std::min<std::size_t>(kMaxLags, static_cast<std::size_t>(shorter) / 3 + 1);
  add_pairs(stack, values, mask, grid);
}

void SpatialStructure::add_tiles(const ColorStack& stack, const ImageF& values, const ImageU8& mask,
                                 const BlockGrid& grid) {
  const int size = tile_px_;
  const auto n = static_cast<std::size_t>(size);
  const int num_rings = static_cast<int>(std::lround(2.0 * std::log2(size / 2.0)));
  for (int r = 0; r < num_rings; ++r) frequencies_.push_back(std::pow(2.0, (r + 0.5) / 2.0) / size);
  std::vector<double> window(n);
  for (std::size_t i = 0; i < n; ++i)
    window[i] = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / size);
  std::vector<std::uint16_t> block_at(static_cast<std::size_t>(mask.num_pixels()));
  for (std::size_t i = 0; i < stack.texels.size(); ++i) block_at[stack.texels[i]] = grid.block_of[i];
  std::vector<Complex> field(n * n);
  for (int y0 = 0; y0 + size <= stack.height; y0 += size / 2) {
    for (int x0 = 0; x0 + size <= stack.width; x0 += size / 2) {
      if (mask.at(x0 + size / 2, y0 + size / 2) == 0) continue;
      double count = 0.0, sum = 0.0;
      for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
          if (mask.at(x0 + x, y0 + y) == 0) continue;
          count += 1.0;
          sum += static_cast<double>(values.at(x0 + x, y0 + y));
        }
      }
      if (count < 0.9 * size * size) continue;
      double weight = 0.0;
      for (std::size_t y = 0; y < n; ++y) {
        for (std::size_t x = 0; x < n; ++x) {
          const int px = x0 + static_cast<int>(x), py = y0 + static_cast<int>(y);
          const double w = mask.at(px, py) != 0 ? window[x] * window[y] : 0.0;
          field[y * n + x] = w * (static_cast<double>(values.at(px, py)) - sum / count);
          weight += w * w;
        }
      }
      for (std::size_t y = 0; y < n; ++y) transform(&field[y * n], n, 1);
      for (std::size_t x = 0; x < n; ++x) transform(&field[x], n, n);
      Tile tile{block_at[static_cast<std::size_t>(y0 + size / 2) * static_cast<std::size_t>(stack.width) +
                         static_cast<std::size_t>(x0 + size / 2)],
                std::vector<double>(frequencies_.size())};
      std::vector<double> counts(frequencies_.size());
      for (std::size_t y = 0; y < n; ++y) {
        for (std::size_t x = 0; x < n; ++x) {
          const double u = x <= n / 2 ? static_cast<double>(x) : static_cast<double>(x) - size,
                       v = y <= n / 2 ? static_cast<double>(y) : static_cast<double>(y) - size;
          const int ring = ring_of(u, v, size);
          if (ring < 0) continue;
          tile.power[ring] += std::norm(field[y * n + x]) / weight;
          counts[ring] += 1.0;
        }
      }
      for (std::size_t r = 0; r < counts.size(); ++r) tile.power[r] /= std::max(counts[r], 1.0);
      tiles_.push_back(std::move(tile));
    }
  }
}

void SpatialStructure::add_pairs(const ColorStack& stack, const ImageF& values, const ImageU8& mask,
                                 const BlockGrid& grid) {
  pairs_.resize(grid.num_blocks() * kDirections * num_lags_);
  for (std::size_t i = 0; i < stack.texels.size(); ++i) {
    const int x = static_cast<int>(stack.texels[i]) % stack.width, y = static_cast<int>(stack.texels[i]) / stack.width;
    const double v = static_cast<double>(values.at(x, y));
    for (std::size_t d = 0; d < kDirections; ++d) {
      Sums* sums = &pairs_[(grid.block_of[i] * kDirections + d) * num_lags_];
      for (std::size_t lag = 0; lag < num_lags_; ++lag) {
        const int px = x + kStepX[d] * static_cast<int>(lag), py = y + kStepY[d] * static_cast<int>(lag);
        if (!mask.contains(px, py)) break;
        if (mask.at(px, py) == 0) continue;
        const double other = static_cast<double>(values.at(px, py));
        sums[lag].count += 1.0;
        sums[lag].product += v * other;
        sums[lag].sum += v + other;
      }
    }
  }
}

std::vector<double> SpatialStructure::spectrum(std::span<const int> weights) const {
  std::vector<double> power(frequencies_.size());
  double total = 0.0;
  for (const Tile& tile : tiles_) {
    const double w = weights[tile.block];
    total += w;
    for (std::size_t r = 0; r < power.size(); ++r) power[r] += w * tile.power[r];
  }
  if (total == 0.0) return {};
  for (double& p : power) p /= total;
  return power;
}

std::vector<double> SpatialStructure::covariances(std::span<const int> weights, std::size_t direction) const {
  std::vector<Sums> total(num_lags_);
  for (std::size_t b = 0; b < weights.size(); ++b) {
    for (std::size_t lag = 0; lag < num_lags_ && weights[b] != 0; ++lag) {
      const Sums& s = pairs_[(b * kDirections + direction) * num_lags_ + lag];
      total[lag].count += weights[b] * s.count;
      total[lag].product += weights[b] * s.product;
      total[lag].sum += weights[b] * s.sum;
    }
  }
  std::vector<double> out;
  const double mean = total[0].count > 0.0 ? total[0].sum / total[0].count / 2.0 : 0.0;
  for (const Sums& s : total) {
    if (s.count == 0.0) break;
    out.push_back(s.product / s.count - mean * s.sum / s.count + mean * mean);
  }
  return out;
}

std::optional<double> SpatialStructure::correlation_length(std::span<const int> weights) const {
  constexpr double kNoVariance = 1e-4;  // L*^2: below any 8-bit step.
  std::vector<std::vector<double>> curves;
  for (std::size_t d = 0; d < kDirections; ++d) curves.push_back(covariances(weights, d));
  if (curves[0].empty() || !(curves[0][0] > kNoVariance)) return std::nullopt;
  const auto correlation = [&](double distance) -> std::optional<double> {
    double sum = 0.0;
    for (std::size_t d = 0; d < kDirections; ++d) {
      const double at = distance / kStepLength[d];
      const auto k = static_cast<std::size_t>(at);
      if (k + 1 >= curves[d].size()) return std::nullopt;
      const double f = at - static_cast<double>(k);
      sum += ((1.0 - f) * curves[d][k] + f * curves[d][k + 1]) / curves[d][0];
    }
    return sum / static_cast<double>(kDirections);
  };
  const double level = std::exp(-1.0);
  double before = 1.0;
  for (double distance = 0.25;; distance += 0.25) {
    const std::optional<double> now = correlation(distance);
    if (!now) return std::nullopt;
    if (*now <= level) return distance - 0.25 * (level - *now) / (before - *now);
    before = *now;
  }
}

}  // namespace patinate::analysis
