#include "analysis/figures/aging.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr double kOnsetShare = 0.1, kSaturationShare = 0.9;  ///< Shares of the rise (docs/algorithms/compare.md).

/// First time at which a non-decreasing curve reaches a level that it does reach.
double crossing(const std::vector<double>& times, const std::vector<double>& curve, double level) {
  std::size_t k = 0;
  while (k + 1 < curve.size() && curve[k] < level) ++k;
  if (k == 0 || curve[k] == curve[k - 1]) return times[k];
  const double f = (level - curve[k - 1]) / (curve[k] - curve[k - 1]);
  return times[k - 1] + std::clamp(f, 0.0, 1.0) * (times[k] - times[k - 1]);
}

}  // namespace

std::vector<double> monotone_fit(std::span<const double> values) {
  struct Pool {
    double sum;
    std::size_t count;
  };
  std::vector<Pool> pools;
  for (double v : values) {
    pools.push_back({v, 1});
    while (pools.size() > 1) {
      const Pool& last = pools.back();
      Pool& before = pools[pools.size() - 2];
      if (before.sum * static_cast<double>(last.count) <= last.sum * static_cast<double>(before.count)) break;
      before.sum += last.sum;
      before.count += last.count;
      pools.pop_back();
    }
  }
  std::vector<double> fit;
  fit.reserve(values.size());
  for (const Pool& p : pools) fit.insert(fit.end(), p.count, p.sum / static_cast<double>(p.count));
  return fit;
}

std::pair<double, double> seen_between(double time, const std::vector<double>& frames) {
  const double tolerance = 1e-6 * (frames.back() - frames.front());
  const auto after = std::lower_bound(frames.begin(), frames.end(), time - tolerance);
  if (after == frames.begin() || after == frames.end()) return {time, time};
  return std::abs(*after - time) <= tolerance ? std::pair(*after, *after) : std::pair(*(after - 1), *after);
}

TexelAging texel_aging(const ColorStack& stack, double visible_delta_e, const RunControl& control) {
  if (stack.num_times() < 2) throw InvalidInput("aging: at least two times are needed");
  if (!(visible_delta_e > 0.0)) throw InvalidInput("aging: the visible difference must be > 0");
  const std::size_t n = stack.num_texels(), num_times = stack.num_times();
  TexelAging out;
  out.change.resize(n);
  out.ages.resize(n);
  out.onset.resize(n);
  out.saturation.resize(n);
  out.covered_at.resize(n);
  parallel_for(static_cast<std::int64_t>(n), 2048, control, [&](std::int64_t begin, std::int64_t end) {
    std::vector<double> distance(num_times);
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const float* first = stack.lab_of(0, i);
      for (std::size_t t = 0; t < num_times; ++t) {
        const float* now = stack.lab_of(t, i);
        double sum = 0.0;
        for (int c = 0; c < 3; ++c)
          sum += (static_cast<double>(now[c]) - static_cast<double>(first[c])) *
                 (static_cast<double>(now[c]) - static_cast<double>(first[c]));
        distance[t] = std::sqrt(sum);
      }
      const std::vector<double> curve = monotone_fit(distance);
      const double low = curve.front(), rise = curve.back() - low;
      out.change[i] = static_cast<float>(rise);
      out.ages[i] = rise >= visible_delta_e;
      out.covered_at[i] =
          static_cast<std::uint16_t>(std::lower_bound(curve.begin(), curve.end(), visible_delta_e) - curve.begin());
      if (!out.ages[i]) continue;
      out.onset[i] = static_cast<float>(crossing(stack.times, curve, low + kOnsetShare * rise));
      out.saturation[i] = static_cast<float>(crossing(stack.times, curve, low + kSaturationShare * rise));
    }
  });
  return out;
}

}  // namespace patinate::analysis
