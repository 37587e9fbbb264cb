// The curve: from the leading temporal component of some places, by turns of clocks for every place and a joint fit.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/factorization/curve_refine.h"
#include "analysis/factorization/place_fit.h"
#include "analysis/factorization/temporal_curve.h"
#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "patinate/analysis/factorization.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::int64_t kCandidates = 4096;  ///< Places that are looked at.
constexpr double kStrongest = 0.6;          ///< Share of the candidates that change: those that change most.
constexpr double kFitShare = 0.1;           ///< Share of a round's time, for the places one by one.
constexpr std::array<int, 4> kIterations{25, 25, 25, 60};  ///< Iterations of the joint fit, for every round.
constexpr double kDomainTail = 0.005;  ///< Share of clock values excludedside at each end of the curve.
constexpr double kMinNoise = 1e-6;     ///< Linear color.
constexpr double kSigma = 1.4826;      ///< From a median of absolute values to a standard deviation.
constexpr double kClip = 3.0;          ///< Standard deviations, for the correlation.
constexpr int kSamples = 1025;         ///< Samples of the curve, for its lowest and highest value.

/// The places with their series cleaned: for choosing and for the first curve.
PlaceSeries cleaned(const PlaceSeries& places, const std::vector<std::int64_t>& chosen) {
  PlaceSeries out{.times = places.times, .num_channels = places.num_channels};
  for (const std::int64_t i : chosen) {
    for (int c = 0; c < places.num_channels; ++c) {
      const std::vector<float> series = cleaned_series(
          places.place(i) + static_cast<std::size_t>(c) * places.times.size(), places.seen(i), places.times.size());
      out.values.insert(out.values.end(), series.begin(), series.end());
    }
  }
  return out;
}

PlaceSeries picked(const PlaceSeries& places, const std::vector<std::int64_t>& chosen) {
  PlaceSeries out{.times = places.times, .num_channels = places.num_channels};
  const std::size_t size = places.times.size() * static_cast<std::size_t>(places.num_channels);
  for (const std::int64_t i : chosen) {
    out.values.insert(out.values.end(), places.place(i), places.place(i) + size);
    if (!places.is_seen.empty())
      out.is_seen.insert(out.is_seen.end(), places.seen(i), places.seen(i) + places.times.size());
  }
  return out;
}

/// Noise of each channel from one frame to the next: of what does not change, and of what changes slowly.
std::vector<double> first_noise(const PlaceSeries& clean) {
  std::vector<double> noise;
  for (int c = 0; c < clean.num_channels; ++c) {
    std::vector<double> steps;
    for (std::int64_t i = 0; i < clean.num_places(); ++i) {
      const float* v = clean.place(i) + static_cast<std::size_t>(c) * clean.times.size();
      for (std::size_t t = 1; t < clean.times.size(); ++t)
        steps.push_back(std::abs(static_cast<double>(v[t] - v[t - 1])));
    }
    noise.push_back(std::max(kMinNoise, kSigma * median(std::move(steps)) / std::sqrt(2.0)));
  }
  return noise;
}

/// Places that change, spread over how much they do.
std::vector<std::int64_t> training_places(const PlaceSeries& places, const FactorizationOptions& options) {
  std::vector<std::int64_t> candidates;
  const std::int64_t stride = std::max<std::int64_t>(1, places.num_places() / kCandidates);
  for (std::int64_t i = 0; i < places.num_places(); i += stride) {
    const std::uint8_t* seen = places.seen(i);
    if (seen == nullptr || std::count(seen, seen + places.times.size(), std::uint8_t{0}) * 2 <=
                               static_cast<std::ptrdiff_t>(places.times.size()))
      candidates.push_back(i);
  }
  if (candidates.empty())
    throw InvalidInput("factorize: no place is seen in half of the frames; nothing can be fitted");
  const PlaceSeries clean = cleaned(places, candidates);
  const std::vector<double> noise = first_noise(clean);
  const auto num_times = static_cast<Eigen::Index>(places.times.size());
  std::vector<std::pair<double, std::int64_t>> changing;
  double largest = 0.0;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    double strength = 0.0, change = 0.0;
    for (int c = 0; c < places.num_channels; ++c) {
      const Eigen::VectorXd v =
          Eigen::Map<const Eigen::VectorXf>(clean.place(static_cast<std::int64_t>(k)) + c * num_times, num_times)
              .cast<double>();
      change = std::max(change, v.maxCoeff() - v.minCoeff());
      strength += (v.array() - v.mean()).square().sum() / (static_cast<double>(num_times) * std::pow(noise[c], 2));
    }
    largest = std::max(largest, change);
    if (change >= options.least_change) changing.emplace_back(strength, candidates[k]);
  }
  if (changing.empty()) {
    throw InvalidInput("factorize: nothing changes: the largest change of color is " +
                       short_number_text(rounded(largest, 3)) + ", below --least-change " +
                       short_number_text(options.least_change));
  }
  std::stable_sort(changing.begin(), changing.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  const std::size_t count =
      std::max<std::size_t>(1, static_cast<std::size_t>(kStrongest * static_cast<double>(changing.size())));
  const std::size_t wanted = std::min(count, static_cast<std::size_t>(options.num_training));
  std::vector<std::int64_t> chosen;
  for (std::size_t k = 0; k < wanted; ++k) chosen.push_back(changing[k * count / wanted].second);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

/// The leading temporal component of each channel as a curve over the times.
TemporalCurve first_curve(const PlaceSeries& clean, int num_intervals) {
  TemporalCurve curve{.low = clean.times.front(), .high = clean.times.back()};
  const auto num_times = static_cast<Eigen::Index>(clean.times.size());
  for (int c = 0; c < clean.num_channels; ++c) {
    Eigen::MatrixXd series(clean.num_places(), num_times);
    for (std::int64_t i = 0; i < clean.num_places(); ++i)
      series.row(i) = Eigen::Map<const Eigen::RowVectorXf>(clean.place(i) + c * num_times, num_times).cast<double>();
    series.colwise() -= series.rowwise().mean();
    Eigen::VectorXd shape = Eigen::VectorXd::LinSpaced(num_times, -1.0, 1.0);
    for (int i = 0; i < 30; ++i) {
      shape = (series.transpose() * (series * shape)).eval();
      const double length = shape.norm();
      if (!(length > 0.0)) {
        shape = Eigen::VectorXd::LinSpaced(num_times, -1.0, 1.0);
        break;
      }
      shape /= length;
    }
    curve.coefficients.push_back(fitted_curve(curve.low, curve.high, num_intervals, clean.times,
                                              std::vector<double>(shape.data(), shape.data() + shape.size())));
  }
  return curve;
}

/// Lowest 0, highest 1, ending no lower than it begins; gains and bases follow.
void normalize(TemporalCurve& curve, std::vector<PlaceFactors>& factors) {
  for (int c = 0; c < curve.num_channels(); ++c) {
    const auto k = static_cast<std::size_t>(c);
    const std::vector<double> samples = curve.samples(c, kSamples);
    const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
    const bool is_falling = samples.back() < samples.front();
    const double from = is_falling ? *high : *low, range = (is_falling ? -1.0 : 1.0) * std::max(*high - *low, 1e-12);
    for (double& v : curve.coefficients[k]) v = (v - from) / range;
    for (PlaceFactors& f : factors) f.base[k] += f.gain[k] * from, f.gain[k] *= range;
  }
}

/// Sets noise and correlation from what the factors leave over.
void measure_noise(const PlaceSeries& places, const std::vector<PlaceFactors>& factors, TemporalModel& model) {
  const std::size_t num_times = places.times.size();
  model.noise.clear();
  double products = 0.0, squares = 0.0;
  for (int c = 0; c < places.num_channels; ++c) {
    std::vector<double> residuals, sizes;
    for (std::int64_t i = 0; i < places.num_places(); ++i) {
      for (std::size_t t = 0; t < num_times; ++t) {
        const bool is_seen = places.seen(i) == nullptr || places.seen(i)[t] != 0;
        const double v = static_cast<double>(places.place(i)[static_cast<std::size_t>(c) * num_times + t]);
        residuals.push_back(is_seen ? v - factored_value(model.curve, factors[i], c, places.times[t]) : 0.0);
        if (is_seen) sizes.push_back(std::abs(residuals.back()));
      }
    }
    model.noise.push_back(std::max(kMinNoise, kSigma * median(std::move(sizes))));
    // Outliers neither hang together nor count.
    const double most = kClip * model.noise.back();
    for (std::size_t k = 0; k < residuals.size(); ++k) {
      const double a = std::clamp(residuals[k], -most, most) / model.noise.back(),
                   b = k % num_times + 1 < num_times ? std::clamp(residuals[k + 1], -most, most) / model.noise.back()
                                                     : 0.0;
      products += a * b, squares += a * a;
    }
  }
  model.correlation = squares > 0.0 ? std::clamp(products / squares, 0.0, 0.99) : 0.0;
}

/// Every place at rate 1 and offset 0: gain and base by least squares.
std::vector<PlaceFactors> first_factors(const PlaceSeries& clean, const TemporalCurve& curve) {
  std::vector<PlaceFactors> factors(static_cast<std::size_t>(clean.num_places()),
                                    PlaceFactors{.status = PlaceStatus::Fitted});
  const auto n = static_cast<Eigen::Index>(clean.times.size());
  for (int c = 0; c < clean.num_channels; ++c) {
    Eigen::VectorXd shape(n);
    for (Eigen::Index t = 0; t < n; ++t) shape[t] = curve.value(c, clean.times[t]);
    const double mean = shape.mean(), squares = std::max(1e-12, (shape.array() - mean).square().sum());
    for (std::int64_t i = 0; i < clean.num_places(); ++i) {
      const Eigen::VectorXd v = Eigen::Map<const Eigen::VectorXf>(clean.place(i) + c * n, n).cast<double>();
      PlaceFactors& f = factors[i];
      const auto k = static_cast<std::size_t>(c);
      f.gain[k] = (v.array() * (shape.array() - mean)).sum() / squares, f.base[k] = v.mean() - f.gain[k] * mean;
    }
  }
  return factors;
}

/// Brings the curve's domain to the clock values that occur.
void follow_clocks(const std::vector<double>& times, const std::vector<PlaceFactors>& factors, int num_intervals,
                   TemporalCurve& curve) {
  std::vector<double> clocks;
  for (const PlaceFactors& f : factors) {
    for (const double t : times) clocks.push_back(f.rate * t - f.offset);
  }
  std::sort(clocks.begin(), clocks.end());
  const auto tail = static_cast<std::size_t>(kDomainTail * static_cast<double>(clocks.size()));
  curve = moved_curve(curve, clocks[tail], clocks[clocks.size() - 1 - tail], num_intervals);
}

}  // namespace

TemporalModel train_curve(const PlaceSeries& places, const FactorizationOptions& options, const RunControl& control) {
  check_ranges(options);
  if (static_cast<int>(places.times.size()) < kLeastFrames) (void)fit_places(places, {}, options);  // Says so.
  const std::vector<std::int64_t> chosen = training_places(places, options);
  const PlaceSeries training = picked(places, chosen), clean = cleaned(places, chosen);
  const int num_intervals = std::min(options.num_intervals, 2 * static_cast<int>(places.times.size() - 1));
  TemporalModel model{.curve = first_curve(clean, num_intervals)};
  std::vector<PlaceFactors> none;
  normalize(model.curve, none);
  measure_noise(clean, first_factors(clean, model.curve), model);
  const double all_iterations = std::accumulate(kIterations.begin(), kIterations.end(), 0.0);
  double share_done = 0.0;
  for (std::size_t round = 0; round < kIterations.size(); ++round) {
    const RunControl part = control.part(share_done, share_done + kIterations[round] / all_iterations);
    share_done += kIterations[round] / all_iterations;
    control.throw_if_stopped();
    std::vector<PlaceFactors> all = fit_places(training, model, options, part.part(0.0, kFitShare));
    measure_noise(training, all, model);
    std::vector<std::int64_t> kept;
    std::vector<PlaceFactors> factors;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all[i].status == PlaceStatus::Fitted || all[i].status == PlaceStatus::Open)
        kept.push_back(static_cast<std::int64_t>(i)), factors.push_back(all[i]);
    }
    if (kept.empty()) throw InvalidInput("factorize: no place changes by more than noise explains");
    const PlaceSeries used = picked(training, kept);
    follow_clocks(used.times, factors, num_intervals, model.curve);
    refine_curve(used, model, factors, kIterations[round], part.part(kFitShare, 1.0));
    normalize(model.curve, factors);
    const ClockGauge gauge = clock_gauge(factors);
    apply_gauge(gauge, model.curve);
    apply_gauge(gauge, factors);
    follow_clocks(used.times, factors, num_intervals, model.curve);
    normalize(model.curve, factors);
    measure_noise(used, factors, model);
  }
  control.report(1.0);
  return model;
}

}  // namespace patinate::analysis
