/// \file
/// How figures of damage go on: laws of growth, each believed as far as it had foretold the series itself.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "analysis/grading/graded_figure.h"

namespace patinate::analysis {

enum class GrowthLaw {
  Held,          ///< Nothing foretells better than the last value.
  Diffusion,     ///< (t - t0)^1/2: parabolic growth.
  Linear,        ///< t - t0.
  Accelerating,  ///< (t - t0)^n, n = 3/2, 2, 3: nuclei that grow at an even rate.
  Saturating,    ///< 1 - exp(-(k (t - t0))^n), n = 1, 2, 3: the same nuclei when they meet [Avrami 1939].
  Logistic       ///< 1 / (1 + exp(-k (t - t0))).
};
inline constexpr std::array<std::string_view, 6> kGrowthLawNames{"held",         "diffusion",  "linear",
                                                                 "accelerating", "saturating", "logistic"};

/// What is said of all series together, and how it did in tests.
struct GrowthTest {
  GrowthLaw law = GrowthLaw::Held;
  double share = 0.0;       ///< Of the law's further change that the series followed, [0, 1]; 0 = held.
  double error = 0.0;       ///< Root mean square of what was foretold, over the range of each series.
  double held_error = 0.0;  ///< The same of the last value that was seen.
};
struct GrowthForecast {
  GrowthTest test = {};
  std::vector<std::vector<GradedFigure>> values = {};  ///< By series, at the times asked for.
};

inline constexpr std::size_t kMinForecastTimes = 6;

/// A law is b + a g(t), least squares over a grid of onsets and speeds, moved to the mean of the last tenth of the
/// series. Tests: each law is fitted to the first half of the times and asked for all later ones, then to more, up to
/// all but one. The law with the least error is taken, times the share of its change that the series followed; it is
/// held unless that takes a tenth off the held error.
/// Intervals of 90 %: errors of the tests grow in proportion to the time ahead over the time seen; Student's factor of
/// three degrees of freedom, as tests of one series overlap; the last value always lies inside, as damage may stop.
/// @param times  Increasing. @param series  One or more of the same figure, each with a value a time.
/// @param ahead  Later times. @param never_falls  The figure is of damage that does not heal.
/// @returns nothing with fewer than kMinForecastTimes times, or where none of the series changes.
[[nodiscard]] std::optional<GrowthForecast> forecast_growth(std::span<const double> times,
                                                            const std::vector<std::vector<double>>& series,
                                                            std::span<const double> ahead, bool never_falls);

}  // namespace patinate::analysis
