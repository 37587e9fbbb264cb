#include "capture/stability/deflicker.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/median.h"

namespace patinate::capture {

namespace {

constexpr int kNumRounds = 4;
constexpr double kTukey = 6.0;         ///< In median absolute residuals, as lowess has it.
constexpr double kLeastSpread = 1e-4;  ///< Of log brightness: less is no outlier.

/// Weighted local line at `at`, or the weighted mean where a line is not determined.
double local_line(const std::vector<double>& curve, const std::vector<double>& robust, int at, int half_width) {
  const int n = static_cast<int>(curve.size());
  double s = 0, sx = 0, sxx = 0, sy = 0, sxy = 0;
  for (int i = std::max(0, at - half_width); i <= std::min(n - 1, at + half_width); ++i) {
    const double u = std::abs(i - at) / (half_width + 1.0), tricube = std::pow(1.0 - u * u * u, 3.0);
    const double w = tricube * robust[static_cast<std::size_t>(i)], x = i - at, y = curve[static_cast<std::size_t>(i)];
    s += w;
    sx += w * x;
    sxx += w * x * x;
    sy += w * y;
    sxy += w * x * y;
  }
  if (!(s > 0.0)) return curve[static_cast<std::size_t>(at)];
  const double determinant = s * sxx - sx * sx;
  constexpr double kSingular = 1e-9;
  return determinant > kSingular * s * s ? (sxx * sy - sx * sxy) / determinant : sy / s;
}

std::vector<double> smooth_curve(const std::vector<double>& curve, int half_width) {
  std::vector<double> robust(curve.size(), 1.0), smooth(curve.size());
  for (int round = 0; round < kNumRounds; ++round) {
    std::vector<double> residuals;
    for (std::size_t i = 0; i < curve.size(); ++i) {
      smooth[i] = local_line(curve, robust, static_cast<int>(i), half_width);
      residuals.push_back(std::abs(curve[i] - smooth[i]));
    }
    const double limit = kTukey * std::max(median(residuals), kLeastSpread);
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const double t = residuals[i] / limit;
      robust[i] = t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0;
    }
  }
  return smooth;
}

}  // namespace

void describe(OptionVisitor& v, DeflickerOptions& o) {
  v.visit(
      {"deflicker_half_width", "Brightness that changes over more frames than so many on either side is the material's",
       "frames", between(1, 1000)},
      o.half_width);
}

std::vector<std::array<double, 3>> deflicker_factors(const std::vector<std::array<double, 3>>& log_gains,
                                                     const DeflickerOptions& options) {
  check_ranges(options);
  std::vector<std::array<double, 3>> factors(log_gains.size() + 1);
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> curve{0.0};
    for (const auto& gain : log_gains) curve.push_back(curve.back() + gain[c]);
    const std::vector<double> smooth = smooth_curve(curve, options.half_width);
    for (std::size_t i = 0; i < curve.size(); ++i) factors[i][c] = std::exp(smooth[i] - curve[i]);
  }
  return factors;
}

}  // namespace patinate::capture
