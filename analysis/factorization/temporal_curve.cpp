#include "analysis/factorization/temporal_curve.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "libcommon/geometry/dense_solve.h"

namespace patinate::analysis {

namespace {

constexpr double kBendingAtStart = 1e-7;  ///< Weight of bending, in units of one value's weight, per coefficient.
constexpr int kSamplesPerInterval = 8;    ///< Samples of the drawn and searched curve.

TemporalCurve domain_only(double low, double high, int num_intervals) {
  return {.low = low, .high = high, .coefficients = {std::vector<double>(static_cast<std::size_t>(num_intervals) + 3)}};
}

}  // namespace

CurveBasis curve_basis(const TemporalCurve& curve, double clock) {
  const int intervals = curve.num_intervals();
  const double per_clock = intervals / (curve.high - curve.low), x = (clock - curve.low) * per_clock;
  const double inside =
      x > 0.0 ? std::min(x, static_cast<double>(intervals)) : 0.0;  // NaN too is somewhere on the curve.
  const int k = std::min(static_cast<int>(inside), intervals - 1);
  const double u = inside - k, v = 1.0 - u, scale = x == inside ? per_clock : 0.0;
  CurveBasis basis{.first = static_cast<std::size_t>(k)};
  basis.weights = {v * v * v / 6.0, (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
                   (-3.0 * u * u * u + 3.0 * u * u + 3.0 * u + 1.0) / 6.0, u * u * u / 6.0};
  basis.slopes = {-0.5 * v * v * scale, (1.5 * u * u - 2.0 * u) * scale, (-1.5 * u * u + u + 0.5) * scale,
                  0.5 * u * u * scale};
  return basis;
}

double TemporalCurve::value(int channel, double clock) const {
  const CurveBasis basis = curve_basis(*this, clock);
  const std::vector<double>& c = coefficients[channel];
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += basis.weights[i] * c[basis.first + i];
  return sum;
}

std::vector<double> TemporalCurve::samples(int channel, int count) const {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(value(channel, low + (high - low) * i / (count - 1)));
  return out;
}

std::vector<double> fitted_curve(double low, double high, int num_intervals, std::span<const double> clocks,
                                 std::span<const double> values) {
  const TemporalCurve domain = domain_only(low, high, num_intervals);
  const auto size = static_cast<Eigen::Index>(num_intervals) + 3;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  for (std::size_t i = 0; i < clocks.size(); ++i) {
    const CurveBasis b = curve_basis(domain, clocks[i]);
    for (std::size_t p = 0; p < 4; ++p) {
      const auto row = static_cast<Eigen::Index>(b.first + p);
      right[row] += b.weights[p] * values[i];
      for (std::size_t q = 0; q < 4; ++q)
        normal(row, static_cast<Eigen::Index>(b.first + q)) += b.weights[p] * b.weights[q];
    }
  }
  const double bending = kBendingAtStart * static_cast<double>(clocks.size());
  constexpr std::array<double, 3> kSecond{1.0, -2.0, 1.0};  // Second difference, whose square is the bending.
  for (Eigen::Index k = 0; k + 2 < size; ++k) {
    for (Eigen::Index p = 0; p < 3; ++p) {
      for (Eigen::Index q = 0; q < 3; ++q) normal(k + p, k + q) += bending * kSecond[p] * kSecond[q];
    }
  }
  normal.diagonal().array() += 1e-12 * static_cast<double>(clocks.size());
  const Eigen::VectorXd solution = solve_ldlt(normal, right);
  return {solution.data(), solution.data() + solution.size()};
}

TemporalCurve moved_curve(const TemporalCurve& curve, double low, double high, int num_intervals) {
  TemporalCurve out{.low = low, .high = high};
  std::vector<double> clocks;
  for (int i = 0; i <= kSamplesPerInterval * num_intervals; ++i)
    clocks.push_back(low + (high - low) * i / (kSamplesPerInterval * num_intervals));
  for (int c = 0; c < curve.num_channels(); ++c) {
    std::vector<double> values;
    for (const double s : clocks) values.push_back(curve.value(c, s));
    out.coefficients.push_back(fitted_curve(low, high, num_intervals, clocks, values));
  }
  return out;
}

}  // namespace patinate::analysis
