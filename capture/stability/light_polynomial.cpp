#include "capture/stability/light_polynomial.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/median.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::capture {

namespace {

constexpr int kPolynomialRounds = 12;  ///< Rounds with robust weights.

}  // namespace

Eigen::VectorXd monomials(double x, double y, int order) {
  Eigen::VectorXd terms((order + 1) * (order + 2) / 2);
  Eigen::Index k = 0;
  for (int degree = 0; degree <= order; ++degree) {
    for (int j = 0; j <= degree; ++j) terms[k++] = std::pow(x, degree - j) * std::pow(y, j);
  }
  return terms;
}

Eigen::VectorXd fit_polynomial(const std::vector<Eigen::VectorXd>& terms, const std::vector<double>& values) {
  const Eigen::Index n = terms.front().size();
  std::vector<double> weights(values.size(), 1.0);
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(n);
  for (int round = 0; round < kPolynomialRounds; ++round) {
    Eigen::MatrixXd normal = 1e-9 * Eigen::MatrixXd::Identity(n, n);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (std::size_t i = 0; i < values.size(); ++i) {
      normal.noalias() += weights[i] * terms[i] * terms[i].transpose();
      right.noalias() += weights[i] * values[i] * terms[i];
    }
    coefficients = solve_ldlt(normal, right);
    std::vector<double> residuals;
    for (std::size_t i = 0; i < values.size(); ++i) residuals.push_back(values[i] - coefficients.dot(terms[i]));
    std::vector<double> sizes = residuals;
    for (double& r : sizes) r = std::abs(r);
    const double limit = kTukeyLimit * std::max(kSigmaOfMad * median(sizes), 1e-6);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double t = residuals[i] / limit;
      weights[i] = std::abs(t) < 1.0 ? (1 - t * t) * (1 - t * t) : 0.0;
    }
  }
  return coefficients;
}

}  // namespace patinate::capture
