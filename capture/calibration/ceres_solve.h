/// \file
/// What every least-squares problem here does with Ceres: solve without a word, and say how well its parameters are
/// known.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ceres {
class Problem;
}

namespace patinate::capture {

struct SolveReport {
  bool has_converged = false;
  int num_iterations = 0;
};
/// Dense, one thread (sums in one order: equal bits), nothing printed; until a step changes parameters by less than
/// 1e-12 of their size.
/// @param independent  Blocks of which no two stand in one residual, as those of each photograph alone: they are solved
/// for first (Schur's complement), so that their number costs little. Empty = none.
SolveReport solve_quietly(ceres::Problem& problem, int max_iterations = 200,
                          const std::vector<double*>& independent = {});

/// Gauss-Newton's view of a solution. Parameters are stacked as `blocks` are given, each in its tangent space.
struct Information {
  bool is_determined =
      false;  ///< Whether the information can be inverted: reciprocal condition above 1e-13, its diagonal brought to 1.
  double condition = 0.0;      ///< The reciprocal condition.
  Eigen::MatrixXd covariance;  ///< For residuals of unit variance; empty when undetermined.
  Eigen::VectorXd weakest;     ///< Unit vector, parameters scaled by the diagonal: what is known worst.
  double sum_squares = 0.0;    ///< Sum squares of the residuals, without the loss.
  int num_residuals = 0;
  int num_parameters = 0;
};
/// @param blocks  Every block of the problem that is not constant. Residuals that a loss weighs down count as much as
/// the loss lets them.
[[nodiscard]] Information information_of(ceres::Problem& problem, const std::vector<double*>& blocks);

/// Residuals at the present parameters, each at its full size however its loss weighs it.
[[nodiscard]] std::vector<double> residuals_without_loss(ceres::Problem& problem);

/// 1.4826 times the median of |residuals|: the standard deviation of most of them. @param residuals  Not empty.
[[nodiscard]] double robust_sigma(std::vector<double> residuals);

}  // namespace patinate::capture
