#include "libcommon/geometry/dense_solve.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace patinate {

Eigen::VectorXd solve_lu(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.partialPivLu().solve(right);
}

Eigen::MatrixXd inverse_by_lu(const Eigen::MatrixXd& matrix) { return matrix.inverse(); }

Eigen::VectorXd shortest_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return shortest_least_squares(matrix, Eigen::MatrixXd(right));
}
Eigen::MatrixXd shortest_least_squares(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right) {
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
