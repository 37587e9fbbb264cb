#include "capture/calibration/ceres_solve.h"

#include <ceres/ceres.h>

#include <cmath>
#include <memory>

#include "libcommon/core/median.h"
#include "libcommon/core/silent_log.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::capture {

namespace {

/// Inverse condition of the scaled normal equations; rounding of doubles is 1e-16.
constexpr double kMinCondition = 1e-13;

}  // namespace

SolveReport solve_quietly(ceres::Problem& problem, int max_iterations, const std::vector<double*>& independent) {
  const SilentLog silent;
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  if (problem.NumResiduals() > 2000) options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  if (!independent.empty()) {
    std::vector<double*> blocks;
    problem.GetParameterBlocks(&blocks);
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (double* block : blocks) ordering->AddElementToGroup(block, 1);
    for (double* block : independent) ordering->AddElementToGroup(block, 0);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering = ordering;
  }
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-16;
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-16;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {.has_converged = summary.termination_type == ceres::CONVERGENCE,
          .num_iterations = static_cast<int>(summary.iterations.size())};
}

Information information_of(ceres::Problem& problem, const std::vector<double*>& blocks) {
  const SilentLog silent;
  Information info;
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = blocks;
  options.num_threads = 1;
  ceres::CRSMatrix jacobian;
  problem.Evaluate(options, nullptr, nullptr, nullptr, &jacobian);
  for (const double r : residuals_without_loss(problem)) info.sum_squares += r * r;
  info.num_residuals = jacobian.num_rows;
  info.num_parameters = jacobian.num_cols;
  const int n = jacobian.num_cols;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    const auto begin = static_cast<std::size_t>(jacobian.rows[row]);
    const auto end = static_cast<std::size_t>(jacobian.rows[static_cast<std::size_t>(row) + 1]);
    for (std::size_t a = begin; a < end; ++a) {
      for (std::size_t b = begin; b < end; ++b)
        normal(jacobian.cols[a], jacobian.cols[b]) += jacobian.values[a] * jacobian.values[b];
    }
  }
  if (n == 0 || !normal.allFinite()) return info;
  Eigen::VectorXd scale(n);
  for (int i = 0; i < n; ++i) scale[i] = normal(i, i) > 0 ? 1.0 / std::sqrt(normal(i, i)) : 0.0;
  const SymmetricEigen<Eigen::MatrixXd> eigen =
      symmetric_eigen(Eigen::MatrixXd(scale.asDiagonal() * normal * scale.asDiagonal()));
  info.condition = eigen.values[0] / eigen.values[n - 1];
  info.weakest = eigen.vectors.col(0);
  // A parameter that nothing depends on is the weakest.
  for (int i = 0; i < n; ++i) {
    if (!(scale[i] > 0)) info.weakest = Eigen::VectorXd::Unit(n, i), info.condition = 0.0;
  }
  info.is_determined = info.condition > kMinCondition;
  if (!info.is_determined) return info;
  const Eigen::VectorXd inverse = eigen.values.cwiseInverse();
  info.covariance =
      scale.asDiagonal() * eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose() * scale.asDiagonal();
  return info;
}

std::vector<double> residuals_without_loss(ceres::Problem& problem) {
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;
  options.num_threads = 1;
  std::vector<double> residuals;
  problem.Evaluate(options, nullptr, &residuals, nullptr, nullptr);
  return residuals;
}

double robust_sigma(std::vector<double> residuals) {
  for (double& r : residuals) r = std::abs(r);
  return 1.4826 * median(std::move(residuals));
}

}  // namespace patinate::capture
