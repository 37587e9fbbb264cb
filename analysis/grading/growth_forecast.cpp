#include "analysis/grading/growth_forecast.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libcommon/core/median.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kNumLaws = kGrowthLawNames.size();
constexpr double kMaxSkilledError = 0.9;  // Of the squared held error: below it a law has skill.
constexpr double kStudentFactor = 2.353;  // 95th percentile, three degrees of freedom.
constexpr std::size_t kMaxOrigins = 12;   // Tests of a series; more overlap more.
constexpr double kEndShare = 0.1;         // Of the times, to whose mean a law is moved.
constexpr double kNoiseOfBend = 2.449;    // sqrt(6): of y2 - 2 y1 + y0 over that of y.

using Values = std::vector<double>;

/// A law with its onset and speed, times from 0 to 1 over what was seen.
struct Shape {
  GrowthLaw law;
  double onset, power, speed;

  [[nodiscard]] double at(double t) const {
    if (law == GrowthLaw::Logistic) return 1.0 / (1.0 + std::exp(-speed * (t - onset)));
    const double since = std::max(0.0, t - onset);
    return law == GrowthLaw::Saturating ? 1.0 - std::exp(-std::pow(speed * since, power)) : std::pow(since, power);
  }
};

/// Half octaves of speeds and onsets at every twentieth of the time.
std::vector<Shape> all_shapes() {
  std::vector<Shape> shapes;
  for (int k = 0; k <= 16; ++k) {
    const double onset = k / 20.0;
    shapes.push_back({GrowthLaw::Diffusion, onset, 0.5, 1.0});
    shapes.push_back({GrowthLaw::Linear, onset, 1.0, 1.0});
    for (const double power : {1.5, 2.0, 3.0}) shapes.push_back({GrowthLaw::Accelerating, onset, power, 1.0});
    for (const double power : {1.0, 2.0, 3.0}) {
      for (int j = -2; j <= 10; ++j) shapes.push_back({GrowthLaw::Saturating, onset, power, std::exp2(0.5 * j)});
    }
  }
  for (int k = 0; k <= 15; ++k) {
    for (int j = 2; j <= 12; ++j) shapes.push_back({GrowthLaw::Logistic, k / 10.0, 1.0, std::exp2(0.5 * j)});
  }
  return shapes;
}

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// What each law says of the times ahead; empty where it cannot be fitted.
using ByLaw = std::array<Values, kNumLaws>;

ByLaw fit_laws(std::span<const double> times, std::span<const double> values, std::span<const double> ahead) {
  static const std::vector<Shape> shapes = all_shapes();
  const double begin = times.front(), span = times.back() - begin, mean = mean_of(values);
  const std::size_t count = times.size(),
                    end = std::max<std::size_t>(
                        1, static_cast<std::size_t>(std::lround(kEndShare * static_cast<double>(count))));
  ByLaw out;
  std::array<double, kNumLaws> least{};
  Values g(count);
  for (const Shape& shape : shapes) {
    for (std::size_t i = 0; i < count; ++i) g[i] = shape.at((times[i] - begin) / span);
    const double g_mean = mean_of(g);
    double squares = 0.0, products = 0.0, error = 0.0, end_error = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      squares += (g[i] - g_mean) * (g[i] - g_mean);
      products += (g[i] - g_mean) * (values[i] - mean);
    }
    if (!(squares > 1e-12)) continue;
    const double slope = products / squares;
    for (std::size_t i = 0; i < count; ++i) {
      const double residual = values[i] - mean - slope * (g[i] - g_mean);
      error += residual * residual;
      if (i + end >= count) end_error += residual / static_cast<double>(end);
    }
    const auto law = static_cast<std::size_t>(shape.law);
    if (!out[law].empty() && error >= least[law]) continue;
    least[law] = error;
    out[law].clear();
    for (const double t : ahead) out[law].push_back(mean + slope * (shape.at((t - begin) / span) - g_mean) + end_error);
  }
  return out;
}

/// One later time of a test: how much the series changed, and what the laws had said.
struct Trial {
  double change = 0.0;
  double ahead = 0.0;  ///< Over the time seen.
  double range = 1.0;  ///< Of the series.
  std::array<double, kNumLaws> said{};
};

double range_of(const Values& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

void add_trials(std::span<const double> times, const Values& values, std::vector<Trial>& trials) {
  const std::size_t count = times.size(), first = std::max<std::size_t>(kMinForecastTimes - 1, (count + 1) / 2),
                    num_origins = std::min(kMaxOrigins, count - first);
  for (std::size_t k = 0; k < num_origins; ++k) {
    const std::size_t seen = first + k * (count - first) / num_origins;
    const std::span<const double> ahead = times.subspan(seen);
    const ByLaw laws = fit_laws(times.first(seen), std::span(values).first(seen), ahead);
    for (std::size_t i = 0; i < ahead.size(); ++i) {
      Trial trial{.change = values[seen + i] - values[seen - 1],
                  .ahead = (ahead[i] - times[seen - 1]) / (times[seen - 1] - times.front()),
                  .range = range_of(values)};
      for (std::size_t law = 1; law < kNumLaws; ++law)
        trial.said[law] = laws[law].empty() ? 0.0 : laws[law][i] - values[seen - 1];
      trials.push_back(trial);
    }
  }
}

/// The law that did best, and what of its change the series followed.
GrowthTest best_of(const std::vector<Trial>& trials) {
  const auto mean_square = [&](auto error) {
    double sum = 0.0;
    for (const Trial& t : trials) sum += error(t) / t.range * (error(t) / t.range);
    return sum / static_cast<double>(trials.size());
  };
  const double held = mean_square([](const Trial& t) { return t.change; });
  GrowthTest best{.error = std::sqrt(held), .held_error = std::sqrt(held)};
  double least = kMaxSkilledError * held;
  for (std::size_t law = 1; law < kNumLaws; ++law) {
    double products = 0.0, squares = 0.0;
    for (const Trial& t : trials) {
      products += t.change * t.said[law] / (t.range * t.range);
      squares += t.said[law] * t.said[law] / (t.range * t.range);
    }
    const double share = squares > 0.0 ? std::clamp(products / squares, 0.0, 1.0) : 0.0;
    const double error = mean_square([&](const Trial& t) { return t.change - share * t.said[law]; });
    if (share == 0.0 || !(error < least)) continue;
    least = error;
    best = {static_cast<GrowthLaw>(law), share, std::sqrt(error), std::sqrt(held)};
  }
  return best;
}

/// Standard deviation of a value's noise, from how single values stand out from their neighbors.
double noise_of(const Values& values) {
  Values bends;
  for (std::size_t i = 2; i < values.size(); ++i)
    bends.push_back(std::abs(values[i] - 2.0 * values[i - 1] + values[i - 2]));
  return kSigmaOfMad * median(std::move(bends)) / kNoiseOfBend;
}

/// By how much what is foretold is off, over the range and the time ahead.
double error_growth(const std::vector<Trial>& trials, const GrowthTest& test) {
  double products = 0.0, squares = 0.0;
  for (const Trial& t : trials) {
    const double error = (t.change - test.share * t.said[static_cast<std::size_t>(test.law)]) / t.range;
    products += t.ahead * t.ahead * error * error;
    squares += std::pow(t.ahead, 4.0);
  }
  return std::sqrt(products / squares);
}

}  // namespace

std::optional<GrowthForecast> forecast_growth(std::span<const double> times, const std::vector<Values>& series,
                                              std::span<const double> ahead, bool never_falls) {
  if (times.size() < kMinForecastTimes) return std::nullopt;
  std::vector<Trial> trials;
  for (const Values& values : series) {
    if (range_of(values) > 0.0) add_trials(times, values, trials);
  }
  if (trials.empty()) return std::nullopt;
  GrowthForecast out{.test = best_of(trials)};
  const double growth = error_growth(trials, out.test), seen = times.back() - times.front();
  for (const Values& values : series) {
    const double last = values.back(), noise = noise_of(values);
    const ByLaw laws = fit_laws(times, values, ahead);
    const Values& said = laws[static_cast<std::size_t>(out.test.law)];
    std::vector<GradedFigure>& figures = out.values.emplace_back();
    for (std::size_t i = 0; i < ahead.size(); ++i) {
      const double change = said.empty() ? 0.0 : out.test.share * (said[i] - last);
      const double value = last + (never_falls ? std::max(0.0, change) : change);
      const double spread =
          kStudentFactor * std::hypot(std::sqrt(2.0) * noise,  // The last value's, and that of the one to come.
                                      growth * range_of(values) * (ahead[i] - times.back()) / seen);
      figures.push_back({value, std::min(never_falls ? std::max(last, value - spread) : value - spread, last),
                         std::max(value + spread, last)});
    }
  }
  return out;
}

}  // namespace patinate::analysis
