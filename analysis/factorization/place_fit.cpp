#include "analysis/factorization/place_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "analysis/factorization/temporal_curve.h"
#include "libcommon/core/median.h"

namespace patinate::analysis {

namespace {

constexpr int kRateSteps = 17, kDelaySteps = 33;  ///< Steps of the grid.
constexpr double kLargestDelay = 0.5;             ///< Largest delay of the grid, as a share of the span.
constexpr int kHalfWindow = 3;                    ///< Half window of the filter against outliers [Hampel 1974].
constexpr double kOutlier = 3.0 * 1.4826;         ///< Three standard deviations, from the median absolute deviation.
constexpr int kMostSteps = 40, kOtherSteps = 8;   ///< From the best start, and from the other as long as it is behind.
constexpr double kMinGain = 1e-7;                 ///< Relative fall of the cost at which the search ends.
constexpr double kSignificant =
    40.0;  ///< Fall of the cost that noise alone does not give: chi-square of 5 at 1e-6, and a search.
constexpr double kKnownRate =
    0.35;  ///< Standard deviation of log rate up to which it is known: half of what is expected unseen.
constexpr int kMaxParameters = 8;  ///< Gain and base of three channels, rate and offset.

using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxParameters, 1>;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxParameters, kMaxParameters>;

bool is_seen(const std::uint8_t* seen, std::size_t t) { return seen == nullptr || seen[t] != 0; }

}  // namespace

std::vector<float> cleaned_series(const float* values, const std::uint8_t* seen, std::size_t num_times) {
  std::vector<std::size_t> known;
  for (std::size_t t = 0; t < num_times; ++t) {
    if (is_seen(seen, t)) known.push_back(t);
  }
  std::vector<float> clean(num_times);
  if (known.empty()) return clean;
  std::vector<float> window, distances;
  for (std::size_t i = 0; i < known.size(); ++i) {
    window.clear();
    const std::size_t first = i < kHalfWindow ? 0 : i - kHalfWindow, last = std::min(known.size() - 1, i + kHalfWindow);
    for (std::size_t j = first; j <= last; ++j) window.push_back(values[known[j]]);
    const float middle = value_at_rank(window, window.size() / 2), value = values[known[i]];
    distances.clear();
    for (const float w : window) distances.push_back(std::abs(w - middle));
    const double spread = static_cast<double>(value_at_rank(distances, distances.size() / 2));
    clean[known[i]] = static_cast<double>(std::abs(value - middle)) > kOutlier * spread + 1e-6 ? middle : value;
  }
  // Gaps: what was seen before, or first.
  std::size_t at = 0;
  for (std::size_t t = 0; t < num_times; ++t) {
    while (at + 1 < known.size() && known[at + 1] <= t) ++at;
    if (is_seen(seen, t)) continue;
    const std::size_t a = known[at], b = known[std::min(at + 1, known.size() - 1)];
    const float share = a < t && t < b ? static_cast<float>(t - a) / static_cast<float>(b - a) : 0.0f;
    clean[t] = (1.0f - share) * clean[a] + share * clean[b];
  }
  return clean;
}

struct PlaceFit::State {
  Clock clock;
  std::array<double, 3> gain = {}, base = {};
  double cost = 0.0;
  double log_rate_variance = 0.0;
};

PlaceFit::PlaceFit(const TemporalModel& model, const std::vector<double>& times, const FactorizationOptions& options)
    : model_(model),
      times_(times),
      options_(options),
      middle_(0.5 * (times.front() + times.back())),
      span_(times.back() - times.front()) {
  for (std::size_t c = 0; c < model.noise.size(); ++c) scale_.push_back(model.scale(c));
  const double largest = std::log(options.max_rate);
  for (int i = 0; i < kRateSteps; ++i) {
    for (int k = 0; k < kDelaySteps; ++k) {
      grid_.push_back(
          {largest * (2.0 * i / (kRateSteps - 1) - 1.0), kLargestDelay * span_ * (2.0 * k / (kDelaySteps - 1) - 1.0)});
    }
  }
  const auto num_times = static_cast<Eigen::Index>(times.size());
  for (int c = 0; c < model.curve.num_channels(); ++c) {
    Eigen::MatrixXf rows(static_cast<Eigen::Index>(grid_.size()), num_times);
    for (std::size_t g = 0; g < grid_.size(); ++g) {
      Eigen::VectorXd row(num_times);
      for (Eigen::Index t = 0; t < num_times; ++t) {
        const double time = times[t];
        row[t] = model.curve.value(c, std::exp(grid_[g].log_rate) * (time - middle_) + middle_ - grid_[g].delay);
      }
      row.array() -= row.mean();
      const double length = row.norm();
      if (length > 1e-6)
        row /= length;
      else
        row.setZero();
      rows.row(static_cast<Eigen::Index>(g)) = row.cast<float>();
    }
    templates_.push_back(std::move(rows));
  }
}

/// Whether means over stretches of time differ by more than noise from one frame to the next leaves, and visibly. What
/// the curve misses of other places is no noise here: it would hide any change.
bool PlaceFit::has_changed(const float* values, const std::uint8_t* seen) const {
  constexpr std::size_t kMaxStretches = 6, kMinInOne = 3;  // See docs/algorithms/factorization.md.
  constexpr double kErrors =
      6.0;  // Standard errors: for the largest of 45 differences, and noise known from a few frames.
  std::vector<std::size_t> known;
  for (std::size_t t = 0; t < times_.size(); ++t) {
    if (is_seen(seen, t)) known.push_back(t);
  }
  const std::size_t num_stretches = std::min(kMaxStretches, known.size() / kMinInOne);
  if (num_stretches < 2) return false;
  for (std::size_t c = 0; c < templates_.size(); ++c) {
    const std::vector<float> clean = cleaned_series(values + c * times_.size(), seen, times_.size());
    const float* const raw = values + c * times_.size();  // The cleaned series has less noise.
    std::vector<double> steps;
    for (std::size_t i = 1; i < known.size(); ++i)
      steps.push_back(std::abs(static_cast<double>(raw[known[i]]) - static_cast<double>(raw[known[i - 1]])));
    const double noise = 1.4826 * median(steps) / std::sqrt(2.0);
    double low = 1e300, high = -1e300;
    for (std::size_t k = 0; k < num_stretches; ++k) {
      const std::size_t begin = k * known.size() / num_stretches, end = (k + 1) * known.size() / num_stretches;
      double mean = 0.0;
      for (std::size_t i = begin; i < end; ++i)
        mean += static_cast<double>(clean[known[i]]) / static_cast<double>(end - begin);
      low = std::min(low, mean), high = std::max(high, mean);
    }
    const double error =
        noise * std::sqrt(2.0 * static_cast<double>(num_stretches) / static_cast<double>(known.size()));
    if (high - low > std::max(options_.least_change, kErrors * error)) return true;
  }
  return false;
}

/// The best of the grid, and the best of those with quite another rate.
std::vector<PlaceFit::Clock> PlaceFit::starts(const float* values, const std::uint8_t* seen) const {
  Eigen::VectorXd explained = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(grid_.size()));
  for (std::size_t c = 0; c < templates_.size(); ++c) {
    const std::vector<float> clean = cleaned_series(values + c * times_.size(), seen, times_.size());
    Eigen::VectorXf series = Eigen::Map<const Eigen::VectorXf>(clean.data(), static_cast<Eigen::Index>(clean.size()));
    series.array() -= series.mean();
    explained += ((templates_[c] * series).cast<double>() / scale_[c]).array().square().matrix();
  }
  for (std::size_t g = 0; g < grid_.size(); ++g) {
    const double r = grid_[g].log_rate / kRateWidth, d = grid_[g].delay / (kDelayWidth * span_);
    explained[static_cast<Eigen::Index>(g)] -= r * r + d * d;
  }
  Eigen::Index best = 0;
  (void)explained.maxCoeff(&best);
  Eigen::Index other = -1;
  for (Eigen::Index g = 0; g < explained.size(); ++g) {
    if (std::abs(g / kDelaySteps - best / kDelaySteps) >= 4 && (other < 0 || explained[g] > explained[other]))
      other = g;
  }
  return {grid_[best], grid_[other]};
}

void PlaceFit::start_linear(State& state, const float* values, const std::uint8_t* seen) const {
  for (std::size_t c = 0; c < templates_.size(); ++c) {
    const std::vector<float> clean = cleaned_series(values + c * times_.size(), seen, times_.size());
    double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (std::size_t t = 0; t < times_.size(); ++t) {
      if (!is_seen(seen, t)) continue;
      const double x = model_.curve.value(
          static_cast<int>(c), std::exp(state.clock.log_rate) * (times_[t] - middle_) + middle_ - state.clock.delay);
      const double y = static_cast<double>(clean[t]);
      n += 1.0, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    const double spread = sxx - sx * sx / n;
    state.gain[c] = spread > 1e-9 * n ? (sxy - sx * sy / n) / spread : 0.0;
    state.base[c] = (sy - state.gain[c] * sx) / n;
  }
}

double PlaceFit::cost(const State& state, const float* values, const std::uint8_t* seen,
                      const std::vector<double>& scale) const {
  const double r = state.clock.log_rate / kRateWidth, d = state.clock.delay / (kDelayWidth * span_),
               rate = std::exp(state.clock.log_rate);
  double sum = r * r + d * d;
  const double k2 = kCauchyScale * kCauchyScale;
  for (std::size_t t = 0; t < times_.size(); ++t) {
    if (!is_seen(seen, t)) continue;
    const CurveBasis basis = curve_basis(model_.curve, rate * (times_[t] - middle_) + middle_ - state.clock.delay);
    for (std::size_t c = 0; c < templates_.size(); ++c) {
      double phi = 0.0;
      for (std::size_t i = 0; i < 4; ++i) phi += basis.weights[i] * model_.curve.coefficients[c][basis.first + i];
      const double z =
          (static_cast<double>(values[c * times_.size() + t]) - state.base[c] - state.gain[c] * phi) / scale[c];
      sum += k2 * std::log1p(z * z / k2);
    }
  }
  return sum;
}

PlaceFit::State PlaceFit::refined(const Clock& start, double to_beat, const float* values,
                                  const std::uint8_t* seen) const {
  State state{.clock = start};
  start_linear(state, values, seen);
  state.cost = cost(state, values, seen, scale_);
  const auto channels = static_cast<Eigen::Index>(templates_.size());
  const Eigen::Index size = 2 + 2 * channels;
  const double k2 = kCauchyScale * kCauchyScale, largest = std::log(options_.max_rate);
  double damping = 1e-3;
  for (int step = 0; step < kMostSteps && (step < kOtherSteps || state.cost < to_beat); ++step) {
    Matrix normal = Matrix::Zero(size, size);
    Vector gradient = Vector::Zero(size);
    const double rate = std::exp(state.clock.log_rate), rw = kRateWidth * kRateWidth,
                 dw = kDelayWidth * span_ * kDelayWidth * span_;
    normal(0, 0) = 1.0 / rw, normal(1, 1) = 1.0 / dw;
    gradient[0] = -state.clock.log_rate / rw, gradient[1] = -state.clock.delay / dw;
    for (std::size_t t = 0; t < times_.size(); ++t) {
      if (!is_seen(seen, t)) continue;
      const double along = rate * (times_[t] - middle_);
      const CurveBasis basis = curve_basis(model_.curve, along + middle_ - state.clock.delay);
      for (std::size_t c = 0; c < templates_.size(); ++c) {
        double phi = 0.0, slope = 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
          phi += basis.weights[i] * model_.curve.coefficients[c][basis.first + i];
          slope += basis.slopes[i] * model_.curve.coefficients[c][basis.first + i];
        }
        const double s = 1.0 / scale_[c],
                     z = (static_cast<double>(values[c * times_.size() + t]) - state.base[c] - state.gain[c] * phi) * s;
        const double w = 1.0 / (1.0 + z * z / k2);
        const std::array<double, 4> j{state.gain[c] * slope * along * s, -state.gain[c] * slope * s, phi * s, s};
        const std::array<Eigen::Index, 4> at{0, 1, 2 + 2 * static_cast<Eigen::Index>(c),
                                             3 + 2 * static_cast<Eigen::Index>(c)};
        for (std::size_t p = 0; p < 4; ++p) {
          gradient[at[p]] += w * z * j[p];
          for (std::size_t q = 0; q < 4; ++q) normal(at[p], at[q]) += w * j[p] * j[q];
        }
      }
    }
    // The data determine it as far as they can; the prior does the rest.
    const Matrix inverse =
        (normal + Matrix::Identity(size, size) * 1e-12 * normal.trace()).ldlt().solve(Matrix::Identity(size, size));
    state.log_rate_variance = std::max(0.0, inverse(0, 0));
    bool is_better = false;
    double fall = 0.0;
    for (int attempt = 0; attempt < 8 && !is_better; ++attempt) {
      Matrix damped = normal;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-12 * normal.trace();
      const Vector move = damped.ldlt().solve(gradient);
      State next = state;
      next.clock.log_rate = std::clamp(state.clock.log_rate + move[0], -largest, largest);
      next.clock.delay = std::clamp(state.clock.delay + move[1], -span_, span_);
      for (std::size_t c = 0; c < templates_.size(); ++c) {
        next.gain[c] += move[2 + 2 * static_cast<Eigen::Index>(c)];
        next.base[c] += move[3 + 2 * static_cast<Eigen::Index>(c)];
      }
      next.cost = cost(next, values, seen, scale_);
      is_better = next.cost < state.cost;
      fall = state.cost - next.cost;
      if (is_better) state = next;
      damping = is_better ? std::max(1e-9, 0.2 * damping) : 8.0 * damping;
    }
    if (!is_better || fall < kMinGain * state.cost) break;
  }
  return state;
}

PlaceFactors PlaceFit::solve(const float* values, const std::uint8_t* seen) const {
  PlaceFactors place;
  const std::size_t num_times = times_.size(), channels = templates_.size();
  int num_seen = 0;
  for (std::size_t t = 0; t < num_times; ++t) num_seen += is_seen(seen, t) ? 1 : 0;
  if (num_seen == 0) return place;
  // One color for all times: the median, then the robust mean from there.
  const double k2 = kCauchyScale * kCauchyScale;
  double constant_cost = 0.0;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<double> list;
    for (std::size_t t = 0; t < num_times; ++t) {
      if (is_seen(seen, t)) list.push_back(static_cast<double>(values[c * num_times + t]));
    }
    double base = median(list);
    for (int i = 0; i < 5; ++i) {
      double sum = 0.0, weights = 0.0;
      for (const double v : list) {
        const double z = (v - base) / model_.noise[c], w = 1.0 / (1.0 + z * z / k2);
        sum += w * v, weights += w;
      }
      base = sum / weights;
    }
    for (const double v : list) constant_cost += k2 * std::log1p(std::pow((v - base) / model_.noise[c], 2) / k2);
    place.base[c] = base;
  }
  std::optional<State> best;
  if (num_seen >= kLeastFrames) {
    for (const Clock& start : starts(values, seen)) {
      const State state = refined(start, best ? best->cost : 1e300, values, seen);
      if (!best || state.cost < best->cost) best = state;
    }
    place.status = PlaceStatus::Unchanged;
    double change = 0.0;
    for (std::size_t c = 0; c < channels; ++c) {
      double low = 1e300, high = -1e300;
      for (std::size_t t = 0; t < num_times; ++t) {
        if (!is_seen(seen, t)) continue;
        const double v = model_.curve.value(
            static_cast<int>(c), std::exp(best->clock.log_rate) * (times_[t] - middle_) + middle_ - best->clock.delay);
        low = std::min(low, v), high = std::max(high, v);
      }
      change = std::max(change, std::abs(best->gain[c]) * (high - low));
    }
    if (change >= options_.least_change && constant_cost - cost(*best, values, seen, model_.noise) > kSignificant) {
      place.status = std::sqrt(best->log_rate_variance) <= kKnownRate ? PlaceStatus::Fitted : PlaceStatus::Open;
      place.rate = std::exp(best->clock.log_rate);
      place.offset = (place.rate - 1.0) * middle_ + best->clock.delay;
      place.rate_stddev = place.rate * std::sqrt(best->log_rate_variance);
      place.gain = best->gain, place.base = best->base;
    } else if (has_changed(values, seen)) {
      place.status = PlaceStatus::Otherwise;
    }
  }
  double squares = 0.0;
  for (std::size_t t = 0; t < num_times; ++t) {
    if (!is_seen(seen, t)) continue;
    for (std::size_t c = 0; c < channels; ++c) {
      const double r = static_cast<double>(values[c * num_times + t]) -
                       factored_value(model_.curve, place, static_cast<int>(c), times_[t]);
      squares += r * r;
    }
  }
  place.residual = std::sqrt(squares / static_cast<double>(num_seen * static_cast<int>(channels)));
  return place;
}

}  // namespace patinate::analysis
