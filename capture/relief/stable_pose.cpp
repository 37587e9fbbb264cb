#include "capture/relief/stable_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "libcommon/core/median.h"
#include "libcommon/core/random.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr std::size_t kFewestPlaces = 12;  ///< Twice the six unknowns of a motion.
constexpr int kDraws = 500;        ///< With 6 degrees of freedom and 0.6 unchanged, 23 of them are of unchanged places.
constexpr int kFirstSteps = 2;     ///< First steps of concentration, for every draw.
constexpr int kLastSteps = 20;     ///< Concentration steps of the best starts [Rousseeuw and Van Driessen 2006].
constexpr std::size_t kKept = 10;  ///< Draws that are followed to the end, as the source has it.
constexpr int kRounds = 20;        ///< Rounds of places that agree; it ends earlier where they stay the same.
constexpr double kAgrees = 3.0;    ///< Standard deviations.
/// Squared mean slope along a degree of freedom, against the best one, below which it is noise of normals: 3 %.
constexpr double kMinConstraint = 1e-3;

using Rows = Eigen::MatrixXd;

/// Rows of the motion in units of the surface's size, over the standard deviations.
struct System {
  Rows rows;              ///< Places x degrees of freedom that are constrained.
  Eigen::VectorXd right;  ///< -change / deviation.
  Rows motion_from_dofs;  ///< 6 x degrees of freedom.
};

System constrained_system(std::span<const HeightDifference> differences, double size) {
  const auto n = static_cast<Eigen::Index>(differences.size());
  Rows all(n, 6);
  Eigen::VectorXd right(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const HeightDifference& d = differences[i];
    Vec6 row = d.row;
    row.head<3>() /= size;
    all.row(i) = row.transpose() / std::sqrt(d.variance);
    right[i] = -d.change / std::sqrt(d.variance);
  }
  const SymmetricEigen<Matrix6> solver = symmetric_eigen(Matrix6(all.transpose() * all));
  const double most = solver.values[5];
  Eigen::Index first = 0;
  while (first < 5 && solver.values[first] < kMinConstraint * most) ++first;
  Rows basis = solver.vectors.rightCols(6 - first);
  System system{all * basis, right, basis};
  system.motion_from_dofs.topRows<3>() /= size;
  return system;
}

double inner_scale_of(const Eigen::VectorXd& residuals) {
  std::vector<double> sizes(static_cast<std::size_t>(residuals.size()));
  for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = std::abs(residuals[static_cast<Eigen::Index>(i)]);
  return inner_scale(std::move(sizes));
}

/// Least squares over the half of the places that a solution explains best, and the sum of those squares.
struct HalfFit {
  Eigen::VectorXd solution;
  double squares = std::numeric_limits<double>::infinity();
};

HalfFit concentrated(const System& system, const Eigen::VectorXd& start, int num_steps) {
  const Eigen::Index n = system.rows.rows(), dofs = system.rows.cols(), half = (n + dofs + 1) / 2;
  std::vector<std::pair<double, Eigen::Index>> order(static_cast<std::size_t>(n));
  HalfFit fit{.solution = start, .squares = 0.0};
  for (int step = 0; step <= num_steps; ++step) {
    const Eigen::VectorXd residual = system.right - system.rows * fit.solution;
    for (Eigen::Index i = 0; i < n; ++i) order[i] = {residual[i] * residual[i], i};
    std::sort(order.begin(), order.end());
    fit.squares = 0.0;
    Rows normal = Rows::Zero(dofs, dofs);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(dofs);
    for (Eigen::Index k = 0; k < half; ++k) {
      const auto& [square, i] = order[k];
      fit.squares += square;
      normal += system.rows.row(i).transpose() * system.rows.row(i);
      right += system.rows.row(i).transpose() * system.right[i];
    }
    if (step < num_steps) fit.solution = solve_ldlt(normal, right);
  }
  return fit;
}

Eigen::VectorXd least_trimmed_squares(const System& system, std::uint64_t seed) {
  const Eigen::Index n = system.rows.rows(), dofs = system.rows.cols();
  std::vector<HalfFit> best{concentrated(system, Eigen::VectorXd::Zero(dofs), kFirstSteps)};
  for (int draw = 0; draw < kDraws; ++draw) {
    RandomStream random(seed, static_cast<std::uint64_t>(draw));
    Rows rows(dofs, dofs);
    Eigen::VectorXd right(dofs);
    for (Eigen::Index k = 0; k < dofs; ++k) {
      const auto i = static_cast<Eigen::Index>(random.below(static_cast<std::uint32_t>(n)));
      rows.row(k) = system.rows.row(i);
      right[k] = system.right[i];
    }
    const Eigen::VectorXd start = solve_lu(rows, right);
    if (!start.allFinite()) continue;
    HalfFit fit = concentrated(system, start, kFirstSteps);
    if (fit.solution.allFinite() && std::isfinite(fit.squares)) best.push_back(std::move(fit));
  }
  const auto is_better = [](const HalfFit& a, const HalfFit& b) { return a.squares < b.squares; };
  std::stable_sort(best.begin(), best.end(), is_better);
  best.resize(std::min<std::size_t>(best.size(), kKept));
  for (HalfFit& fit : best) fit = concentrated(system, fit.solution, kLastSteps);
  return std::min_element(best.begin(), best.end(), is_better)->solution;
}

}  // namespace

double inner_scale(std::vector<double> sizes) {
  constexpr double kInside = 2.5;  // Standard deviations: 99 % of a normal distribution.
  double scale = kSigmaOfMad * median(sizes);
  for (std::size_t before = 0; before != sizes.size();) {
    before = sizes.size();
    std::erase_if(sizes, [&](double size) { return size > kInside * scale; });
    scale = kSigmaOfMad * median(sizes);
  }
  return scale;
}

StablePose find_stable_pose(std::span<const HeightDifference> differences, double size, std::uint64_t seed) {
  if (differences.size() < kFewestPlaces)
    throw InvalidInput("placing a scan needs at least " + std::to_string(kFewestPlaces) +
                       " points on unchanged surface; found " + std::to_string(differences.size()));
  StablePose pose;
  const System system = constrained_system(differences, size);
  const Eigen::Index n = system.rows.rows(), dofs = system.rows.cols();
  Eigen::VectorXd x = least_trimmed_squares(system, seed);
  // Rousseeuw's correction is for few places. The scale never grows: a biweight whose scale may could take the changed
  // places in.
  const double correction = 1.0 + 5.0 / static_cast<double>(std::max<Eigen::Index>(n - dofs, 1));
  double scale = std::max(correction * inner_scale_of(system.right - system.rows * x), 1e-9);
  Rows normal = Rows::Identity(dofs, dofs);
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd residual = system.right - system.rows * x;
    scale = std::clamp(correction * inner_scale_of(residual), 1e-9, scale);
    Eigen::VectorXd weights(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double u = residual[i] / (kTukeyLimit * scale);
      weights[i] = std::abs(u) < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
    }
    normal = system.rows.transpose() * weights.asDiagonal() * system.rows;
    x = solve_ldlt(normal, Eigen::VectorXd(system.rows.transpose() * weights.asDiagonal() * system.right));
  }
  const Eigen::VectorXd residual = system.right - system.rows * x;
  std::vector<double> agreeing;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (std::abs(residual[i]) <= kAgrees * scale) agreeing.push_back(std::abs(residual[i]));
  }
  pose.agreeing = static_cast<double>(agreeing.size()) / static_cast<double>(n);
  pose.noise_factor = kSigmaOfMad * correction * median(std::move(agreeing));
  pose.num_dofs = static_cast<int>(dofs);
  pose.motion = system.motion_from_dofs * x;
  const Rows of_dofs = solve_ldlt(normal, Rows(Rows::Identity(dofs, dofs))) * (pose.noise_factor * pose.noise_factor);
  pose.covariance = system.motion_from_dofs * of_dofs * system.motion_from_dofs.transpose();
  return pose;
}

}  // namespace patinate::capture
