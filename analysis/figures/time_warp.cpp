#include "analysis/figures/time_warp.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::int64_t kChunk = 4096;
constexpr int kCoarseSteps = 32, kRefinements = 3;  ///< Steps of half the span; each refinement halves the step.

void require_pair(const ColorStack& a, const ColorStack& b) {
  if (a.texels != b.texels || a.texels.empty())
    throw InvalidInput("time warp: the two sides must show the same texels");
  if (a.num_times() < 2 || a.num_times() != b.num_times())
    throw InvalidInput("time warp: at least two times on both sides are needed");
}

/// Mean squared distance of A at every time from B at every time and from the next: what any blend of B's is made of.
struct Gram {
  std::size_t n = 0;
  std::vector<double> ab;    ///< [i][j]: mean |A_i - B_j|^2
  std::vector<double> step;  ///< [j]: mean |B_j+1 - B_j|^2
  std::vector<double> turn;  ///< [i][j]: mean (A_i - B_j) . (B_j+1 - B_j)

  [[nodiscard]] double at(std::size_t i, const StackTime& t) const {
    const std::size_t k = i * n + t.index;
    return t.fraction == 0.0
               ? ab[k]
               : std::max(0.0, ab[k] - 2.0 * t.fraction * turn[k] + t.fraction * t.fraction * step[t.index]);
  }
};

/// The cheapest path.
TimeWarp warp_of(const Gram& gram, const std::vector<double>& times_a, const std::vector<double>& times_b,
                 int fineness) {
  const std::size_t n = gram.n;
  std::vector<double> candidates;
  for (std::size_t j = 0; j + 1 < n; ++j) {
    for (int f = 0; f < fineness; ++f) candidates.push_back(times_b[j] + (times_b[j + 1] - times_b[j]) * f / fineness);
  }
  candidates.push_back(times_b.back());
  double scale = 0.0;
  for (double v : gram.ab) scale = std::max(scale, v);
  const double span = times_b.back() - times_b.front(), price = 1e-6 * std::max(scale, 1e-12) / span;
  const std::size_t m = candidates.size();
  std::vector<double> best(m, 0.0);
  std::vector<std::uint32_t> from(n * m);
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t argument = 0;
    std::vector<double> next(m);
    for (std::size_t j = 0; j < m; ++j) {
      if (best[j] < best[argument]) argument = j;
      from[i * m + j] = static_cast<std::uint32_t>(argument);
      next[j] =
          best[argument] + gram.at(i, locate(times_b, candidates[j])) + price * std::abs(candidates[j] - times_b[i]);
    }
    best = std::move(next);
  }
  TimeWarp warp;
  warp.times = times_a;
  warp.warped.resize(n);
  auto j = static_cast<std::size_t>(std::min_element(best.begin(), best.end()) - best.begin());
  for (std::size_t i = n; i-- > 0;) {
    warp.warped[i] = candidates[j];
    j = from[i * m + j];
  }
  for (std::size_t i = 0; i < n; ++i) {
    warp.before.push_back(std::sqrt(gram.at(i, {i, 0.0})));
    warp.after.push_back(std::sqrt(gram.at(i, locate(times_b, warp.warped[i]))));
  }
  return warp;
}

}  // namespace

StackTime locate(const std::vector<double>& times, double time) {
  if (time <= times.front()) return {0, 0.0};
  if (time >= times.back()) return {times.size() - 1, 0.0};
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  const auto i = static_cast<std::size_t>(next - times.begin()) - 1;
  return {i, (time - times[i]) / (times[i + 1] - times[i])};
}

std::int64_t BlockWarps::memory_bytes(std::size_t num_times, const BlockGrid& blocks) {
  return static_cast<std::int64_t>(blocks.used.size() * (2 * num_times + 1) * num_times * sizeof(double));
}

BlockWarps::BlockWarps(const ColorStack& a, const ColorStack& b, const BlockGrid& blocks, int fineness,
                       const RunControl& control)
    : times_a_(a.times), times_b_(b.times), fineness_(fineness), used_(blocks.used) {
  require_pair(a, b);
  if (fineness < 1 || fineness > 1000) throw InvalidInput("time warp: the fineness must be in [1, 1000]");
  const std::size_t n = a.num_times(), num_blocks = used_.size();
  std::vector<std::size_t> index(blocks.num_blocks());
  for (std::size_t k = 0; k < num_blocks; ++k) index[used_[k]] = k;
  num_texels_.resize(num_blocks);
  for (const std::uint16_t block : blocks.block_of) ++num_texels_[index[block]];
  ab_.resize(num_blocks * n * n);
  turn_.resize(num_blocks * n * n);
  step_.resize(num_blocks * n);
  parallel_for(static_cast<std::int64_t>(n), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const std::span<const float> va = a.lab_at(i);
      for (std::size_t j = 0; j < n; ++j) {
        const std::span<const float> vb = b.lab_at(j), next = b.lab_at(std::min(j + 1, n - 1));
        for (std::size_t k = 0; k < va.size(); ++k) {
          const double d = static_cast<double>(va[k]) - static_cast<double>(vb[k]),
                       s = static_cast<double>(next[k]) - static_cast<double>(vb[k]);
          const std::size_t block = index[blocks.block_of[k / 3]];
          ab_[(block * n + i) * n + j] += d * d;
          turn_[(block * n + i) * n + j] += d * s;
          if (i == 0) step_[block * n + j] += s * s;
        }
      }
    }
  });
}

TimeWarp BlockWarps::warp(const std::vector<int>& weights) const {
  const std::size_t n = times_a_.size();
  Gram gram{
      .n = n, .ab = std::vector<double>(n * n), .step = std::vector<double>(n), .turn = std::vector<double>(n * n)};
  double texels = 0.0;
  for (std::size_t k = 0; k < used_.size(); ++k) texels += weights[used_[k]] * num_texels_[k];
  for (std::size_t k = 0; k < used_.size(); ++k) {
    const double share = weights[used_[k]] / texels;
    if (share == 0.0) continue;
    for (std::size_t e = 0; e < n * n; ++e) gram.ab[e] += share * ab_[k * n * n + e];
    for (std::size_t e = 0; e < n * n; ++e) gram.turn[e] += share * turn_[k * n * n + e];
    for (std::size_t j = 0; j < n; ++j) gram.step[j] += share * step_[k * n + j];
  }
  return warp_of(gram, times_a_, times_b_, fineness_);
}

TimeWarp find_time_warp(const ColorStack& a, const ColorStack& b, int fineness, const RunControl& control) {
  require_pair(a, b);
  const BlockGrid all = make_blocks(a, 1);
  return BlockWarps(a, b, all, fineness, control).warp(all.all());
}

TimeShift find_time_shift(const ColorStack& a, const ColorStack& b, const std::vector<std::uint8_t>& known,
                          const RunControl& control) {
  require_pair(a, b);
  if (known.size() != a.num_texels()) throw InvalidInput("time shift: `known` needs an entry a texel");
  const std::size_t n = a.num_times();
  const double half = (b.times.back() - b.times.front()) / 2.0;
  constexpr int kFine = kCoarseSteps << kRefinements;  // Steps of half the span at the finest.
  // Where every shifted time falls in B.
  std::vector<StackTime> places(static_cast<std::size_t>(2 * kFine + 1) * n);
  for (int k = -kFine; k <= kFine; ++k) {
    for (std::size_t t = 0; t < n; ++t)
      places[static_cast<std::size_t>(k + kFine) * n + t] = locate(b.times, b.times[t] + half * k / kFine);
  }
  TimeShift out{std::vector<float>(a.num_texels()), known};
  parallel_for(static_cast<std::int64_t>(a.num_texels()), kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    std::vector<std::array<double, 3>> ca(n), cb(n);
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      if (known[i] == 0) continue;
      for (std::size_t t = 0; t < n; ++t) {
        for (std::size_t c = 0; c < 3; ++c) {
          ca[t][c] = static_cast<double>(a.lab_of(t, i)[c]);
          cb[t][c] = static_cast<double>(b.lab_of(t, i)[c]);
        }
      }
      const auto cost = [&](int k) {
        double sum = 0.0;
        for (std::size_t t = 0; t < n; ++t) {
          const StackTime& at = places[static_cast<std::size_t>(k + kFine) * n + t];
          const std::array<double, 3>&low = cb[at.index], &high = cb[std::min(at.index + 1, n - 1)];
          for (std::size_t c = 0; c < 3; ++c) {
            const double d = low[c] + at.fraction * (high[c] - low[c]) - ca[t][c];
            sum += d * d;
          }
        }
        return sum;
      };
      int best = 0;
      double least = cost(0);
      const auto consider = [&](int k) {
        if (k < -kFine || k > kFine) return;
        const double c = cost(k);
        if (c < least) least = c, best = k;
      };
      for (int k = 1; k <= kCoarseSteps; ++k) {  // From the middle outwards: the smallest of equally good shifts.
        consider(k * (kFine / kCoarseSteps));
        consider(-k * (kFine / kCoarseSteps));
      }
      for (int step = kFine / kCoarseSteps / 2; step >= 1; step /= 2) {
        const int middle = best;
        consider(middle + step);
        consider(middle - step);
      }
      double shift = best;
      if (best > -kFine && best < kFine && least > 0.0) {
        const double left = cost(best - 1), right = cost(best + 1), bend = left - 2.0 * least + right;
        if (bend > 0.0) shift += std::clamp(0.5 * (left - right) / bend, -0.5, 0.5);
      }
      out.shift[i] = static_cast<float>(half * shift / kFine);
    }
  });
  return out;
}

}  // namespace patinate::analysis
