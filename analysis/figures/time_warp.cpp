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

Gram gram_of(const ColorStack& a, const ColorStack& b, const RunControl& control) {
  Gram g;
  g.n = a.num_times();
  g.ab.resize(g.n * g.n);
  g.turn.resize(g.n * g.n);
  g.step.resize(g.n);
  const auto texels = static_cast<double>(a.num_texels());
  parallel_for(static_cast<std::int64_t>(g.n), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const std::span<const float> va = a.lab_at(i);
      for (std::size_t j = 0; j < g.n; ++j) {
        const std::span<const float> vb = b.lab_at(j), next = b.lab_at(std::min(j + 1, g.n - 1));
        double ab = 0.0, turn = 0.0, step = 0.0;
        for (std::size_t k = 0; k < va.size(); ++k) {
          const double d = static_cast<double>(va[k]) - static_cast<double>(vb[k]),
                       s = static_cast<double>(next[k]) - static_cast<double>(vb[k]);
          ab += d * d;
          turn += d * s;
          step += s * s;
        }
        g.ab[i * g.n + j] = ab / texels;
        g.turn[i * g.n + j] = turn / texels;
        if (i == 0) g.step[j] = step / texels;
      }
    }
  });
  return g;
}

}  // namespace

StackTime locate(const std::vector<double>& times, double time) {
  if (time <= times.front()) return {0, 0.0};
  if (time >= times.back()) return {times.size() - 1, 0.0};
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  const auto i = static_cast<std::size_t>(next - times.begin()) - 1;
  return {i, (time - times[i]) / (times[i + 1] - times[i])};
}

TimeWarp find_time_warp(const ColorStack& a, const ColorStack& b, int fineness, const RunControl& control) {
  require_pair(a, b);
  if (fineness < 1 || fineness > 1000) throw InvalidInput("time warp: the fineness must be in [1, 1000]");
  const Gram gram = gram_of(a, b, control);
  const std::size_t n = a.num_times();
  std::vector<double> candidates;
  for (std::size_t j = 0; j + 1 < n; ++j) {
    for (int f = 0; f < fineness; ++f) candidates.push_back(b.times[j] + (b.times[j + 1] - b.times[j]) * f / fineness);
  }
  candidates.push_back(b.times.back());
  double scale = 0.0;
  for (double v : gram.ab) scale = std::max(scale, v);
  const double span = b.times.back() - b.times.front(), price = 1e-6 * std::max(scale, 1e-12) / span;
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
          best[argument] + gram.at(i, locate(b.times, candidates[j])) + price * std::abs(candidates[j] - b.times[i]);
    }
    best = std::move(next);
  }
  TimeWarp warp;
  warp.times = a.times;
  warp.warped.resize(n);
  auto j = static_cast<std::size_t>(std::min_element(best.begin(), best.end()) - best.begin());
  for (std::size_t i = n; i-- > 0;) {
    warp.warped[i] = candidates[j];
    j = from[i * m + j];
  }
  for (std::size_t i = 0; i < n; ++i) {
    warp.before.push_back(std::sqrt(gram.at(i, {i, 0.0})));
    warp.after.push_back(std::sqrt(gram.at(i, locate(b.times, warp.warped[i]))));
  }
  return warp;
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
