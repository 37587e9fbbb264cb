#include "libcommon/geometry/dense_solve.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace patinate {

Eigen::VectorXd solve_lu(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.partialPivLu().solve(right);
}

Eigen::MatrixXd inverse_by_lu(const Eigen::MatrixXd& matrix) { return matrix.inverse(); }

std::optional<Eigen::Vector3d> solve_full_lu(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& right,
                                             double least_rcond) {
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(matrix);
  if (!(lu.rcond() > least_rcond)) return std::nullopt;
  return Eigen::Vector3d(lu.solve(right));
}

Eigen::VectorXd shortest_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.completeOrthogonalDecomposition().solve(right);
}
Eigen::MatrixXd shortest_least_squares(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right) {
  return matrix.completeOrthogonalDecomposition().solve(right);
}
Eigen::Vector2d shortest_least_squares(const Eigen::Matrix2d& matrix, const Eigen::Vector2d& right) {
  return matrix.completeOrthogonalDecomposition().solve(right);
}

RightSingular right_singular(const Eigen::MatrixXd& matrix) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixV()};
}

Eigen::Matrix3d nearest_orthonormal(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Eigen::MatrixXf orthonormal_columns(const Eigen::MatrixXf& columns) {
  return Eigen::HouseholderQR<Eigen::MatrixXf>(columns).householderQ() *
         Eigen::MatrixXf::Identity(columns.rows(), columns.cols());
}

}  // namespace patinate
