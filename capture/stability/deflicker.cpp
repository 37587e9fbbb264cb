#include "capture/stability/deflicker.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/median.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr int kLineRounds = 4;        ///< Rounds with robust weights.
constexpr std::size_t kNoCourse = 3;  ///< Photographs of which none can be told.
constexpr double kMinOfFew = 0.0488;  ///< Log brightness, 5 %: less may be their material's.
constexpr double kLowessLimit = 6.0;  ///< In median absolute residuals, as lowess has it.
constexpr double kMinSpread = 1e-4;   ///< Log brightness: less is no outlier.

/// Weighted local line at `at`, or the weighted mean where a line is not determined.
double local_line(const std::vector<double>& curve, const std::vector<double>& robust, int at, int half_width) {
  const int n = static_cast<int>(curve.size());
  double s = 0, sx = 0, sxx = 0, sy = 0, sxy = 0;
  for (int i = std::max(0, at - half_width); i <= std::min(n - 1, at + half_width); ++i) {
    const double u = std::abs(i - at) / (half_width + 1.0), tricube = std::pow(1.0 - u * u * u, 3.0);
    const double w = tricube * robust[i], x = i - at, y = curve[i];
    s += w;
    sx += w * x;
    sxx += w * x * x;
    sy += w * y;
    sxy += w * x * y;
  }
  if (!(s > 0.0)) return curve[at];
  const double determinant = s * sxx - sx * sx;
  constexpr double kSingular = 1e-9;  // Relative determinant: times that do not differ give no slope.
  return determinant > kSingular * s * s ? (sxx * sy - sx * sxy) / determinant : sy / s;
}

/// Tukey weights of what is away from `smooth`.
std::vector<double> robust_weights(const std::vector<double>& curve, const std::vector<double>& smooth) {
  std::vector<double> residuals, weights;
  for (std::size_t i = 0; i < curve.size(); ++i) residuals.push_back(std::abs(curve[i] - smooth[i]));
  const double limit = kLowessLimit * std::max(median(residuals), kMinSpread);
  for (double residual : residuals) {
    const double t = residual / limit;
    weights.push_back(t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0);
  }
  return weights;
}

/// The line of repeated medians: half of the points may lie anywhere.
std::vector<double> median_line(const std::vector<double>& curve) {
  std::vector<double> slopes, starts, line;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    std::vector<double> from_here;
    for (std::size_t j = 0; j < curve.size(); ++j) {
      if (j != i) from_here.push_back((curve[j] - curve[i]) / (static_cast<double>(j) - static_cast<double>(i)));
    }
    slopes.push_back(median(std::move(from_here)));
  }
  const double slope = median(std::move(slopes));
  for (std::size_t i = 0; i < curve.size(); ++i) starts.push_back(curve[i] - slope * static_cast<double>(i));
  const double start = median(std::move(starts));
  for (std::size_t i = 0; i < curve.size(); ++i) line.push_back(start + slope * static_cast<double>(i));
  return line;
}

std::vector<double> smooth_curve(const std::vector<double>& curve, int half_width) {
  const std::size_t n = curve.size();
  if (n <= kNoCourse) {
    const auto [low, high] = std::minmax_element(curve.begin(), curve.end());
    if (*high - *low < kMinOfFew) return curve;
    return std::vector<double>(n, n == kNoCourse ? median(curve) : curve.front());
  }
  std::vector<double> robust(n, 1.0), smooth(n);
  if (n <= 2 * static_cast<std::size_t>(half_width) + 1) robust = robust_weights(curve, median_line(curve));
  for (int round = 0; round < kLineRounds; ++round) {
    for (std::size_t i = 0; i < n; ++i) smooth[i] = local_line(curve, robust, static_cast<int>(i), half_width);
    robust = robust_weights(curve, smooth);
  }
  return smooth;
}

}  // namespace

void describe(OptionVisitor& v, DeflickerOptions& o) {
  v.visit({"deflicker_half_width",
           "Changes of brightness over more frames than this, on either side, count as the material's", "frames",
           between(1, 1000)},
          o.half_width);
}

std::vector<std::array<double, 3>> deflicker_factors(const std::vector<std::array<double, 3>>& log_gains,
                                                     const DeflickerOptions& options,
                                                     const std::vector<bool>& is_known) {
  check_ranges(options);
  if (!is_known.empty() && is_known.size() != log_gains.size())
    throw InvalidInput("deflicker: it must be said of every gain whether it is known");
  std::vector<std::array<double, 3>> factors(log_gains.size() + 1);
  std::size_t begin = 0;
  while (begin < factors.size()) {
    std::size_t end = begin + 1;
    while (end < factors.size() && (is_known.empty() || is_known[end - 1])) ++end;
    for (std::size_t c = 0; c < 3; ++c) {
      std::vector<double> curve{0.0};
      for (std::size_t i = begin + 1; i < end; ++i) curve.push_back(curve.back() + log_gains[i - 1][c]);
      const std::vector<double> smooth = smooth_curve(curve, options.half_width);
      for (std::size_t i = begin; i < end; ++i) factors[i][c] = std::exp(smooth[i - begin] - curve[i - begin]);
    }
    begin = end;
  }
  return factors;
}

}  // namespace patinate::capture
