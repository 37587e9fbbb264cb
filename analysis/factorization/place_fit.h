/// \file
/// One place against a known curve: gain and base exactly, rate and offset by a search over a grid and
/// Levenberg-Marquardt from there.
#pragma once

#include <Eigen/Core>

#include "patinate/analysis/factorization.h"

namespace patinate::analysis {

/// Holds what all places share. A place's clock is s(t) = e^r (t - middle) + middle - delay.
class PlaceFit {
 public:
  PlaceFit(const TemporalModel& model, const std::vector<double>& times, const FactorizationOptions& options);
  /// @param values  C x T. @param seen  T, or null.
  [[nodiscard]] PlaceFactors solve(const float* values, const std::uint8_t* seen) const;

  /// Widths of what is expected of a clock before it is seen: of log rate, and of the delay as a share of the span.
  static constexpr double kRateWidth = 0.7, kDelayWidth = 0.35;
  /// Residuals from here on (in standard deviations) count less and less [Cauchy; Holland and Welsch 1977].
  static constexpr double kCauchyScale = 2.385;

 private:
  struct Clock {
    double log_rate = 0.0, delay = 0.0;
  };
  struct State;
  [[nodiscard]] bool has_changed(const float* values, const std::uint8_t* seen) const;
  [[nodiscard]] std::vector<Clock> starts(const float* values, const std::uint8_t* seen) const;
  [[nodiscard]] State refined(const Clock& start, double to_beat, const float* values, const std::uint8_t* seen) const;
  [[nodiscard]] double cost(const State& state, const float* values, const std::uint8_t* seen,
                            const std::vector<double>& scale) const;
  void start_linear(State& state, const float* values, const std::uint8_t* seen) const;

  const TemporalModel& model_;
  const std::vector<double>& times_;
  FactorizationOptions options_;
  double middle_ = 0.0, span_ = 1.0;
  std::vector<double> scale_ = {};  ///< Scale of the residuals of each channel.
  std::vector<Clock> grid_;
  std::vector<Eigen::MatrixXf>
      templates_;  ///< For each channel, grid x T: the curve under every clock of the grid, mean 0, length 1.
};

/// Values with outliers in time and gaps replaced by what stands around them: for starts only.
[[nodiscard]] std::vector<float> cleaned_series(const float* values, const std::uint8_t* seen, std::size_t num_times);

}  // namespace patinate::analysis
