#include <Eigen/Cholesky>

#include "libcommon/geometry/dense_solve.h"

namespace patinate {

Eigen::VectorXd solve_ldlt(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.ldlt().solve(right);
}
Eigen::MatrixXd solve_ldlt(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right) {
  return matrix.ldlt().solve(right);
}
Eigen::Matrix<double, 6, 1> solve_ldlt(const Eigen::Matrix<double, 6, 6>& matrix,
                                       const Eigen::Matrix<double, 6, 1>& right) {
  return matrix.ldlt().solve(right);
}
Eigen::Vector4d solve_ldlt(const Eigen::Matrix4d& matrix, const Eigen::Vector4d& right) {
  return matrix.ldlt().solve(right);
}
Eigen::Vector3d solve_ldlt(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& right) {
  return matrix.ldlt().solve(right);
}

struct LdltFactors::Factors {
  Eigen::LDLT<Eigen::MatrixXd> solver;
};

LdltFactors::LdltFactors(const Eigen::MatrixXd& matrix)
    : factors_(std::make_unique<Factors>(Factors{Eigen::LDLT<Eigen::MatrixXd>(matrix)})) {}
LdltFactors::~LdltFactors() = default;

bool LdltFactors::is_factored() const { return factors_->solver.info() == Eigen::Success; }
double LdltFactors::least_pivot() const { return factors_->solver.vectorD().minCoeff(); }
Eigen::VectorXd LdltFactors::solve(const Eigen::VectorXd& right) const { return factors_->solver.solve(right); }
Eigen::MatrixXd LdltFactors::solve(const Eigen::MatrixXd& right) const { return factors_->solver.solve(right); }

}  // namespace patinate
