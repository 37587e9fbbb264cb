#include "capture/thickness/histogram_peaks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace patinate::capture {

namespace {

constexpr float kValley = 0.5f;  ///< Between two peaks the histogram falls below this share of the lower one.

float sum_around(std::span<const float> histogram, int at, int reach) {
  const auto begin = histogram.begin() + std::max(0, at - reach);
  const auto end = histogram.begin() + std::min(static_cast<int>(histogram.size()), at + reach + 1);
  return std::accumulate(begin, end, 0.0f);
}

/// The highest bin on one side of `at` behind a valley; -1 when there is none. @param step  1 or -1.
int peak_on_side(std::span<const float> histogram, int at, int reach, int step) {
  const auto value = [&](int bin) { return histogram[bin]; };
  const int num_bins = static_cast<int>(histogram.size());
  int best = -1;
  float lowest = value(at);
  for (int bin = at + step; bin >= 0 && bin < num_bins; bin += step) {
    lowest = std::min(lowest, value(bin));
    const bool is_apart = std::abs(bin - at) > 2 * reach && lowest < kValley * value(bin);
    if (is_apart && (best < 0 || value(bin) > value(best))) best = bin;
  }
  return best;
}

}  // namespace

int highest_bin(const float* a, const float* b, float t, std::span<float> blended) {
  std::array<float, kHistogramLanes> best{};
  for (std::size_t bin = 0; bin < blended.size(); bin += kHistogramLanes) {
    for (std::size_t lane = 0; lane < kHistogramLanes; ++lane) {
      const float value = (1.0f - t) * a[bin + lane] + t * b[bin + lane];
      blended[bin + lane] = value;
      best[lane] = value > best[lane] ? value : best[lane];
    }
  }
  const float highest = *std::max_element(best.begin(), best.end());
  return static_cast<int>(std::find(blended.begin(), blended.end(), highest) - blended.begin());
}

double refined_peak(std::span<const float> histogram, int at) {
  const std::size_t bin = at;
  if (at < 1 || bin + 2 > histogram.size() || !(histogram[bin - 1] > 0.0f) || !(histogram[bin + 1] > 0.0f)) return at;
  const float before = std::log(histogram[bin - 1] / histogram[bin]);
  const float after = std::log(histogram[bin + 1] / histogram[bin]);
  const float curvature = before + after;
  if (!(curvature < 0.0f)) return at;
  return at + static_cast<double>(std::clamp(0.5f * (before - after) / curvature, -0.5f, 0.5f));
}

PeakShares peak_shares(std::span<const float> histogram, int at, int reach) {
  const float total = std::accumulate(histogram.begin(), histogram.end(), 0.0f);
  if (!(total > 0.0f)) return {};
  PeakShares shares{.first = sum_around(histogram, at, reach) / total};
  for (int step : {-1, 1}) {
    const int other = peak_on_side(histogram, at, reach, step);
    const float share = other < 0 ? 0.0f : sum_around(histogram, other, reach) / total;
    if (share <= shares.second) continue;
    shares.second = share;
    shares.second_at = other;
  }
  return shares;
}

}  // namespace patinate::capture
