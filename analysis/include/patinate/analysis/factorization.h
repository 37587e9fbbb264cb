/// \file
/// A history as one curve and a few maps: space-time appearance factorization [Gu, Tu, Ramamoorthi, Matusik, Pfister,
/// Nayar 2006].
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"

namespace patinate::analysis {

enum class FactorClock { Shared, Channels };

struct FactorizationOptions {
  FactorClock clock =
      FactorClock::Shared;      ///< One rate and offset of a place, or one for each channel as in the paper.
  int num_intervals = 32;       ///< Number of intervals of the curve's spline; [2, 400].
  double max_rate = 4.0;        ///< Rates are looked for in [1 / max_rate, max_rate]; [1.1, 20].
  double least_change = 0.004;  ///< A place whose color changes by less does not change; linear, > 0.
  int num_training = 256;       ///< Places that the curve is fitted to, with their own clocks; [16, 4096].
};
void describe(OptionVisitor& v, FactorizationOptions& o);

/// Colors of N places at T times: what a factorization is made from.
struct PlaceSeries {
  std::vector<double> times = {};          ///< Strictly increasing; T >= kLeastFrames.
  int num_channels = 3;                    ///< C, 1 to 3.
  std::vector<float> values = {};          ///< N x C x T, finite.
  std::vector<std::uint8_t> is_seen = {};  ///< N x T; 0 = the value is none of the surface. Empty: all are.

  [[nodiscard]] std::int64_t num_places() const {
    return static_cast<std::int64_t>(values.size() / (times.size() * static_cast<std::size_t>(num_channels)));
  }
  [[nodiscard]] const float* place(std::int64_t i) const {
    return values.data() + static_cast<std::size_t>(i) * times.size() * static_cast<std::size_t>(num_channels);
  }
  [[nodiscard]] const std::uint8_t* seen(std::int64_t i) const {
    return is_seen.empty() ? nullptr : is_seen.data() + static_cast<std::size_t>(i) * times.size();
  }
  /// One channel alone.
  [[nodiscard]] PlaceSeries channel(int c) const;
};
inline constexpr int kLeastFrames = 4;

enum class PlaceStatus : std::uint8_t {
  Unseen,     ///< Fewer than kLeastFrames values: base is their mean (0 without any), nothing else is known.
  Unchanged,  ///< Nothing says that it changes. Only base means something: rate and offset are not defined.
  Open,       ///< It changes, but its values leave rate and offset open: they stand near 1 and 0.
  Fitted,
  Otherwise,  ///< It changes, and not as the curve does. Only base means something.
};
inline constexpr std::size_t kNumPlaceStatuses = 5;

/// p(t) = gain phi(rate t - offset) + base.
struct PlaceFactors {
  PlaceStatus status = PlaceStatus::Unseen;
  double rate = 1.0;         ///< Speed of the place's clock relative to the common one.
  double offset = 0.0;       ///< In units of time.
  double rate_stddev = 0.0;  ///< Standard deviation of `rate` because of noise.
  std::array<double, 3> gain = {};
  std::array<double, 3> base = {};
  double residual = 0.0;  ///< Root mean square over channels and seen times, outliers as well.
};

/// Uniform cubic B-splines [de Boor 1978] on [low, high], one per channel; beyond the ends the values at the ends hold.
struct TemporalCurve {
  double low = 0.0, high = 1.0;                        ///< Range of the clock; low < high.
  std::vector<std::vector<double>> coefficients = {};  ///< For every channel num_intervals() + 3.

  [[nodiscard]] int num_channels() const { return static_cast<int>(coefficients.size()); }
  [[nodiscard]] int num_intervals() const { return static_cast<int>(coefficients.front().size()) - 3; }
  [[nodiscard]] double value(int channel, double clock) const;
  /// Values from equally spaced clocks, both ends among them; >= 2.
  [[nodiscard]] std::vector<double> samples(int channel, int count) const;
};

/// The part of a factorization that is fitted to some places and holds for all of them.
struct TemporalModel {
  TemporalCurve curve;  ///< Every channel's lowest value is 0, its highest 1, and it ends no lower than it begins.
  std::vector<double> noise = {};  ///< Standard deviation of most residuals, per channel.
  double correlation = 0.0;  ///< Correlation of residuals in consecutive frames, [0, 0.99]: 0 for noise, larger if the
                             ///< model misses changes.

  /// Residuals that hang together are fewer than they seem: what a residual is measured by, so that sums of squares
  /// count independent ones.
  [[nodiscard]] double scale(std::size_t channel) const {
    return noise[channel] * std::sqrt((1.0 + correlation) / (1.0 - correlation));
  }
};

/// A factorization of places in memory.
struct Factorization {
  std::vector<TemporalModel> models;  ///< One, or one per channel (FactorClock::Channels).
  std::vector<std::vector<PlaceFactors>>
      factors;  ///< For each model, N. With Channels, gain[0] and base[0] are the channel's.
};

/// The curve, from places spread over all that are given: robust, joint with their own clocks. @throws InvalidInput
/// with fewer than kLeastFrames times, or when no place changes (why it says), or on options out of range. Same bits
/// for any number of threads.
[[nodiscard]] TemporalModel train_curve(const PlaceSeries& places, const FactorizationOptions& options,
                                        const RunControl& control = {});
/// Every place by itself, given the curve. Same bits for any number of threads. Cost: about 0.3 ms a place of 100 times
/// and 3 channels.
[[nodiscard]] std::vector<PlaceFactors> fit_places(const PlaceSeries& places, const TemporalModel& model,
                                                   const FactorizationOptions& options, const RunControl& control = {});

/// A transformation of the common clock that changes no color: clock' = scale clock + shift.
struct ClockGauge {
  double scale = 1.0, shift = 0.0;
};
/// The one after which the median rate of fitted places is 1 and their median offset 0; none when no place is fitted.
[[nodiscard]] ClockGauge clock_gauge(const std::vector<PlaceFactors>& factors);
void apply_gauge(const ClockGauge& gauge, TemporalCurve& curve);
void apply_gauge(const ClockGauge& gauge, std::vector<PlaceFactors>& factors);

/// Curve, places and gauge of all of it. @throws InvalidInput as train_curve().
[[nodiscard]] Factorization factorize(const PlaceSeries& places, const FactorizationOptions& options = {},
                                      const RunControl& control = {});
/// Factorizes a history's pixels inside its mask, in reading order. Memory: 12 B per pixel and frame.
[[nodiscard]] Factorization factorize(const History& history, const FactorizationOptions& options = {},
                                      const RunControl& control = {});

/// Colors over time of some pixels, seen where the frames' own masks say so. @param pixels  y * width + x, ascending.
/// @throws IoError
[[nodiscard]] PlaceSeries place_series(const History& history, std::span<const std::uint32_t> pixels,
                                       const RunControl& control = {});

/// One channel of a place at a time.
[[nodiscard]] double factored_value(const TemporalCurve& curve, const PlaceFactors& place, int channel, double time);
/// Says whether the curve is known at that time; an unchanged place is always covered.
[[nodiscard]] bool is_covered(const TemporalCurve& curve, const PlaceFactors& place, double time);

}  // namespace patinate::analysis
