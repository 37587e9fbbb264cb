#include <Eigen/Eigenvalues>

#include "libcommon/geometry/dense_solve.h"

namespace patinate {

namespace {

template <class Matrix>
SymmetricEigen<Matrix> eigen_of_symmetric(const Matrix& matrix) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

}  // namespace

SymmetricEigen<Eigen::MatrixXd> symmetric_eigen(const Eigen::MatrixXd& matrix) { return eigen_of_symmetric(matrix); }
SymmetricEigen<Eigen::MatrixXf> symmetric_eigen(const Eigen::MatrixXf& matrix) { return eigen_of_symmetric(matrix); }
SymmetricEigen<Eigen::Matrix<double, 6, 6>> symmetric_eigen(const Eigen::Matrix<double, 6, 6>& matrix) {
  return eigen_of_symmetric(matrix);
}
SymmetricEigen<Eigen::Matrix3d> symmetric_eigen(const Eigen::Matrix3d& matrix) { return eigen_of_symmetric(matrix); }
SymmetricEigen<Eigen::Matrix2d> symmetric_eigen(const Eigen::Matrix2d& matrix) { return eigen_of_symmetric(matrix); }

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace patinate
