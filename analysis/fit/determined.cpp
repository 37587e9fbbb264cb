#include "analysis/fit/determined.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr double kScanStep = 0.3;              ///< Between one offset of a scan and the next.
constexpr double kNoWay = 1e-6;                ///< Nearer to an end is at the end.
constexpr double kMinExplained = 0.5;          ///< Share of the variance: below, a quadratic is no description.
constexpr double kPointsPerCoefficient = 2.0;  ///< See docs/algorithms/fit.md.
constexpr double kFlattest = 1e-9;             ///< Curvature, against the largest: flatter counts as this.
constexpr double kSamePlace = 1e-9;            ///< Share of a range; rounding.

struct Quadratic {
  Eigen::MatrixXd curvature;  ///< In units of the box.
  double explained = 0.0;
};

/// The least-squares quadratic through the points of least objective.
std::optional<Quadratic> fitted_quadratic(const BoxPoint& best, std::span<const BoxPoint> points,
                                          std::string& problem) {
  const auto n = static_cast<Eigen::Index>(best.at.size());
  const Eigen::Index num_coefficients = (n + 1) * (n + 2) / 2;
  std::vector<const BoxPoint*> near;
  for (const BoxPoint& p : points) {
    if (std::isfinite(p.objective)) near.push_back(&p);
  }
  std::stable_sort(near.begin(), near.end(),
                   [](const BoxPoint* a, const BoxPoint* b) { return a->objective < b->objective; });
  const auto wanted = static_cast<std::size_t>(kPointsPerCoefficient * static_cast<double>(num_coefficients));
  if (near.size() < wanted) {
    problem = "only " + std::to_string(near.size()) + " points were tried; " + std::to_string(wanted) + " are needed";
    return std::nullopt;
  }
  near.resize(wanted);
  const auto m = static_cast<Eigen::Index>(near.size());
  // Each coordinate in units of its own spread, for a well-conditioned matrix.
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    double sum = 0.0;
    for (const BoxPoint* p : near) sum += std::pow(p->at[i] - best.at[i], 2);
    scale[i] = std::max(std::sqrt(sum / static_cast<double>(m)), 1e-6);
  }
  Eigen::MatrixXd a(m, num_coefficients);
  Eigen::VectorXd y(m);
  for (Eigen::Index r = 0; r < m; ++r) {
    const BoxPoint& p = *near[r];
    Eigen::Index c = 0;
    a(r, c++) = 1.0;
    const auto d = [&](Eigen::Index i) { return (p.at[i] - best.at[i]) / scale[i]; };
    for (Eigen::Index i = 0; i < n; ++i) a(r, c++) = d(i);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = i; j < n; ++j) a(r, c++) = d(i) * d(j);
    }
    y[r] = p.objective;
  }
  const Eigen::VectorXd x = shortest_least_squares(a, y);
  const double variance = (y.array() - y.mean()).square().sum();
  // Per degree of freedom: as many coefficients as these explain a part of any noise.
  const double freedom = static_cast<double>(m - 1) / static_cast<double>(m - num_coefficients);
  Quadratic q{.curvature = Eigen::MatrixXd::Zero(n, n),
              .explained = variance > 0.0 ? 1.0 - freedom * (y - a * x).squaredNorm() / variance : 0.0};
  Eigen::Index c = 1 + n;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i; j < n; ++j) {
      const double value = x[c++] / (scale[i] * scale[j]);
      q.curvature(i, j) = q.curvature(j, i) = i == j ? 2.0 * value : value;
    }
  }
  if (!(q.explained >= kMinExplained)) {
    problem = "near the best the objective is no quadratic (one explains " +
              std::to_string(static_cast<int>(100.0 * std::max(0.0, q.explained))) + " % of its variance)";
    return std::nullopt;
  }
  return q;
}

/// Where the line from the best first rises above the threshold on one side; nothing when it does not before the
/// range's end. Between places the square of the objective is taken for a parabola, as that of a distance is:
/// sqrt(f^2 - best^2) is then straight.
std::optional<double> crossing(const BoxPoint& best, std::size_t i, const std::vector<std::pair<double, double>>& side,
                               double threshold) {
  const auto straight = [&](double rise) {
    return rise > 0.0 ? std::sqrt(rise * (rise + 2.0 * std::abs(best.objective))) : 0.0;
  };
  double from = best.at[i], rise_from = 0.0;
  for (const auto& [at, rise] : side) {
    if (rise > threshold) {
      const double a = straight(rise_from), b = straight(rise);
      return from + (at - from) * (b > a ? std::clamp((straight(threshold) - a) / (b - a), 0.0, 1.0) : 0.0);
    }
    from = at;
    rise_from = rise;
  }
  return std::nullopt;
}

/// The least rise at every place on one side of the best, going outward.
std::vector<std::pair<double, double>> least_rises(const BoxPoint& best,
                                                   std::span<const std::vector<BoxPoint>* const> lists, std::size_t i,
                                                   bool is_above) {
  std::vector<std::pair<double, double>> side;
  for (const std::vector<BoxPoint>* list : lists) {
    for (const BoxPoint& p : *list) {
      if ((p.at[i] > best.at[i]) == is_above && p.at[i] != best.at[i])
        side.emplace_back(p.at[i], p.objective - best.objective);
    }
  }
  std::sort(side.begin(), side.end(), [&](const auto& a, const auto& b) {
    return is_above ? a < b : a.first > b.first || (a.first == b.first && a.second < b.second);
  });
  side.erase(std::unique(side.begin(), side.end(),
                         [](const auto& a, const auto& b) { return std::abs(a.first - b.first) < kSamePlace; }),
             side.end());
  return side;
}

ParameterVerdict verdict_of(const BoxPoint& best, std::span<const BoxPoint> tried, const std::vector<BoxPoint>& scan,
                            const std::vector<BoxPoint>& profile, std::size_t i, double threshold) {
  ParameterVerdict v;
  for (const BoxPoint& p : scan) {
    if (std::isfinite(p.objective)) v.effect = std::max(v.effect, std::abs(p.objective - best.objective));
  }
  if (scan.empty()) {
    v.determination = Determination::NotExamined;
    return v;
  }
  if (v.effect == 0.0) {
    v.determination = Determination::WithoutEffect;
    return v;
  }
  const std::array<const std::vector<BoxPoint>*, 2> lists{&scan, &profile};
  std::optional<double> low = crossing(best, i, least_rises(best, lists, i, false), threshold),
                        high = crossing(best, i, least_rises(best, lists, i, true), threshold);
  for (const BoxPoint& p : tried) {
    if (!(p.objective <= best.objective + threshold)) continue;
    if (low) low = std::min(*low, p.at[i]);
    if (high) high = std::max(*high, p.at[i]);
  }
  const bool is_low = low && *low > kNoWay, is_high = high && *high < 1.0 - kNoWay;
  v.low = is_low ? *low : 0.0;
  v.high = is_high ? *high : 1.0;
  v.determination = is_low && is_high ? Determination::Determined
                    : is_low          ? Determination::AtLeast
                    : is_high         ? Determination::AtMost
                                      : Determination::Undetermined;
  return v;
}

}  // namespace

std::vector<double> scan_places(double best, int count) {
  std::vector<double> places;
  double share = 1.0;
  const bool is_wider_above = best < 0.5;
  for (int k = 0; k < (count + 1) / 2; ++k) {
    const bool is_alone = 2 * k + 1 == count;  // The last one of an odd number lies on the wider side.
    if (best > kNoWay && !(is_alone && is_wider_above)) places.push_back(std::max(0.0, best - share * best));
    if (best < 1.0 - kNoWay && !(is_alone && !is_wider_above))
      places.push_back(std::min(1.0, best + share * (1.0 - best)));
    share *= kScanStep;
  }
  return places;
}

std::optional<Valley> valley_of(const BoxPoint& best, std::span<const BoxPoint> points, std::string& problem) {
  const std::optional<Quadratic> q = fitted_quadratic(best, points, problem);
  if (!q) return std::nullopt;
  const SymmetricEigen<Eigen::MatrixXd> eigen = symmetric_eigen(q->curvature);
  const Eigen::VectorXd values = eigen.values.cwiseMax(std::max(kFlattest * eigen.values.maxCoeff(), 1e-300));
  const Eigen::MatrixXd covariance = eigen.vectors * values.cwiseInverse().asDiagonal() * eigen.vectors.transpose();
  const std::size_t n = best.at.size();
  Valley valley{.correlation = {n, std::vector<double>(n, 1.0)},
                .slopes = {n, std::vector<double>(n, 1.0)},
                .explained = q->explained};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      if (i == j) continue;
      const auto r = static_cast<Eigen::Index>(i), c = static_cast<Eigen::Index>(j);
      valley.correlation[i][j] = covariance(r, c) / std::sqrt(covariance(r, r) * covariance(c, c));
      valley.slopes[i][j] = covariance(r, c) / covariance(r, r);
    }
  }
  return valley;
}

std::vector<ParameterVerdict> determine(const BoxPoint& best, std::span<const BoxPoint> tried, const BoxScans& scans,
                                        const BoxScans& profiles, double threshold) {
  const std::size_t n = best.at.size();
  if (n == 0 || scans.size() != n || profiles.size() != n)
    throw InvalidInput("determine: there is not one scan a parameter");
  const auto fits = [n](const BoxPoint& p) { return p.at.size() == n; };
  const auto all_fit = [&](const std::vector<BoxPoint>& list) { return std::all_of(list.begin(), list.end(), fits); };
  if (!std::all_of(tried.begin(), tried.end(), fits) || !std::all_of(scans.begin(), scans.end(), all_fit) ||
      !std::all_of(profiles.begin(), profiles.end(), all_fit)) {
    throw InvalidInput("determine: a point has another number of parameters");
  }
  if (!(threshold >= 0.0)) throw InvalidInput("determine: the threshold must be >= 0");
  std::vector<ParameterVerdict> verdicts;
  for (std::size_t i = 0; i < n; ++i) verdicts.push_back(verdict_of(best, tried, scans[i], profiles[i], i, threshold));
  return verdicts;
}

}  // namespace patinate::analysis
