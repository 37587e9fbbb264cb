/// \file
/// Places that age by a formula, with their truth.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libcommon/core/random.h"
#include "patinate/analysis/factorization.h"

namespace patinate::testing_support {

/// Curves of three channels: a rise with a long tail, a steeper one, and one that overshoots. Ends at 0 and 1 but for
/// 1e-6.
[[nodiscard]] inline double true_curve(int channel, double s) {
  const auto rise = [&](double at, double width) { return 1.0 / (1.0 + std::exp(-(s - at) / width)); };
  if (channel == 0) return 0.6 * rise(35.0, 4.0) + 0.4 * rise(60.0, 7.0);
  if (channel == 1) return rise(42.0, 5.0);
  return rise(38.0, 4.0) - 0.45 * rise(62.0, 6.0);
}

inline const analysis::FactorizationOptions kQuickFactorization{.num_intervals = 24, .num_training = 96};

struct FactoredPlaces {
  analysis::PlaceSeries series;
  std::vector<analysis::PlaceFactors> truth;  ///< Its clock is that of true_curve().
};

struct FactoredOptions {
  int count = 600;
  std::vector<double> times = {};  ///< Empty: 48 uneven ones from 0 to 100.
  double noise = 0.0;              ///< Standard deviation.
  double outliers = 0.0;           ///< Share of the values that are replaced by anything in [0, 1].
  double unseen = 0.0;             ///< Share of places and times that are masked, and hold nonsense.
  double unchanged = 0.0;          ///< Share of places.
  double spread = 0.22;            ///< Spread of log rate.
};

[[nodiscard]] inline FactoredPlaces factored_places(const FactoredOptions& o) {
  FactoredPlaces out;
  out.series.times = o.times;
  if (o.times.empty()) {
    for (int t = 0; t < 48; ++t)
      out.series.times.push_back(100.0 * std::pow((t + (t % 3 == 1 ? 0.4 : 0.0)) / 47.0, 1.15));
  }
  const std::size_t num_times = out.series.times.size();
  for (int i = 0; i < o.count; ++i) {
    RandomStream random(7, static_cast<std::uint64_t>(i));
    analysis::PlaceFactors p;
    p.status = random.uniform() < o.unchanged ? analysis::PlaceStatus::Unchanged : analysis::PlaceStatus::Fitted;
    p.rate = std::exp(o.spread * std::clamp(random.normal(), -2.0, 2.0));
    p.offset = 5.0 * std::clamp(random.normal(), -2.0, 2.0);
    for (std::size_t c = 0; c < 3; ++c) {
      p.gain[c] = p.status == analysis::PlaceStatus::Unchanged
                      ? 0.0
                      : (random.uniform() < 0.3 ? -1.0 : 1.0) * (0.15 + 0.2 * random.uniform());
      p.base[c] = 0.4 + 0.1 * random.uniform();
    }
    for (std::size_t c = 0; c < 3; ++c) {
      for (const double t : out.series.times) {
        double v =
            p.base[c] + p.gain[c] * true_curve(static_cast<int>(c), p.rate * t - p.offset) + o.noise * random.normal();
        if (random.uniform() < o.outliers) v = random.uniform();
        out.series.values.push_back(static_cast<float>(v));
      }
    }
    if (o.unseen > 0.0) {
      for (std::size_t t = 0; t < num_times; ++t) {
        const bool is_seen = random.uniform() >= o.unseen;
        out.series.is_seen.push_back(is_seen ? 255 : 0);
        for (std::size_t c = 0; c < 3 && !is_seen; ++c)
          out.series.values[(static_cast<std::size_t>(i) * 3 + c) * num_times + t] = 9.0f;
      }
    }
    out.truth.push_back(p);
  }
  return out;
}

/// The truth in the gauge of a factorization: its clock by the medians, its curves from 0 to 1 over the fitted domain.
inline void bring_to_gauge(const analysis::TemporalCurve& fitted, std::vector<analysis::PlaceFactors>& truth) {
  const analysis::ClockGauge gauge = analysis::clock_gauge(truth);
  for (int c = 0; c < 3; ++c) {
    double low = 1e9, high = -1e9;
    for (int i = 0; i <= 2000; ++i) {
      const double s = fitted.low + (fitted.high - fitted.low) * i / 2000.0,
                   v = true_curve(c, (s - gauge.shift) / gauge.scale);
      low = std::min(low, v), high = std::max(high, v);
    }
    for (analysis::PlaceFactors& p : truth) {
      p.base[c] += p.gain[c] * low;
      p.gain[c] *= high - low;
    }
  }
  analysis::apply_gauge(gauge, truth);
}

/// 95th percentiles of the differences from the truth, over places that are fitted.
struct FactorErrors {
  double rate = 0.0, offset = 0.0, gain = 0.0, base = 0.0,
         value = 0.0;         ///< Share; time; linear; linear; root mean square.
  double fitted_share = 0.0;  ///< Share of those that change.
};
[[nodiscard]] inline FactorErrors factor_errors(const FactoredPlaces& places, const analysis::Factorization& made) {
  std::vector<analysis::PlaceFactors> truth = places.truth;
  bring_to_gauge(made.models[0].curve, truth);
  std::vector<double> rate, offset, gain, base;
  double squares = 0.0, count = 0.0, changing = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i].status != analysis::PlaceStatus::Fitted) continue;
    changing += 1.0;
    const analysis::PlaceFactors& f = made.factors[0][i];
    for (int c = 0; c < 3; ++c) {
      for (const double t : places.series.times) {
        const auto k = static_cast<std::size_t>(c);
        const double v = places.truth[i].base[k] +
                         places.truth[i].gain[k] * true_curve(c, places.truth[i].rate * t - places.truth[i].offset);
        squares += std::pow(analysis::factored_value(made.models[0].curve, f, c, t) - v, 2), count += 1.0;
      }
    }
    if (f.status != analysis::PlaceStatus::Fitted) continue;
    rate.push_back(std::abs(f.rate / truth[i].rate - 1.0));
    offset.push_back(std::abs(f.offset - truth[i].offset));
    for (std::size_t c = 0; c < 3; ++c)
      gain.push_back(std::abs(f.gain[c] - truth[i].gain[c])), base.push_back(std::abs(f.base[c] - truth[i].base[c]));
  }
  const auto p95 = [](std::vector<double>& list) {
    std::sort(list.begin(), list.end());
    return list.empty() ? 1e9 : list[static_cast<std::size_t>(0.95 * static_cast<double>(list.size() - 1))];
  };
  const double fitted = static_cast<double>(rate.size()) / changing;
  return {.rate = p95(rate),
          .offset = p95(offset),
          .gain = p95(gain),
          .base = p95(base),
          .value = std::sqrt(squares / count),
          .fitted_share = fitted};
}

}  // namespace patinate::testing_support
