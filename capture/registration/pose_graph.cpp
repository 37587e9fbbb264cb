#include "capture/registration/pose_graph.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <array>

#include "libcommon/geometry/dense_solve.h"

namespace patinate::capture {

namespace {

constexpr double kFree = 1e-9;  ///< Share of the largest eigenvalue.

struct EdgeCost {
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> root;  ///< root^T root = information.
  RigidTransform source_from_target;                  ///< Pose as measured.

  template <class T>
  bool operator()(const T* target, const T* source, T* residual) const {
    using Matrix = Eigen::Matrix<T, 3, 3>;
    using Vector = Eigen::Matrix<T, 3, 1>;
    Matrix rt, rs;
    ceres::AngleAxisToRotationMatrix(target, ceres::ColumnMajorAdapter3x3(rt.data()));
    ceres::AngleAxisToRotationMatrix(source, ceres::ColumnMajorAdapter3x3(rs.data()));
    const Vector tt(target[3], target[4], target[5]), ts(source[3], source[4], source[5]);
    const Matrix r = rt.transpose() * rs * source_from_target.rotation.cast<T>();
    const Vector at = rs * source_from_target.translation.cast<T>() + ts;
    const Vector shift = rt.transpose() * (at - tt);
    Eigen::Matrix<T, 6, 1> e;
    ceres::RotationMatrixToAngleAxis(ceres::ColumnMajorAdapter3x3(r.data()), e.data());
    e.template tail<3>() = shift;
    Eigen::Map<Eigen::Matrix<T, 6, 1>> out(residual);
    out = root.cast<T>() * e;
    return true;
  }
};

Matrix6 root_of(const Matrix6& information) {
  const SymmetricEigen<Matrix6> solver = symmetric_eigen(information);
  return solver.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * solver.vectors.transpose();
}

}  // namespace

std::vector<RigidTransform> solve_poses(std::span<const RigidTransform> world_from_scan,
                                        std::span<const PoseEdge> edges, int fixed) {
  std::vector<std::array<double, 6>> values(world_from_scan.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    Eigen::Map<Vec3>(values[k].data()) = axis_angle_of(world_from_scan[k].rotation);
    Eigen::Map<Vec3>(values[k].data() + 3) = world_from_scan[k].translation;
  }
  ceres::Problem problem;
  for (const PoseEdge& edge : edges) {
    auto* cost = new ceres::AutoDiffCostFunction<EdgeCost, 6, 6, 6>(
        new EdgeCost{root_of(edge.information), edge.target_from_source.inverse()});
    problem.AddResidualBlock(cost, nullptr, values[edge.target].data(), values[edge.source].data());
  }
  std::vector<RigidTransform> poses(world_from_scan.begin(), world_from_scan.end());
  if (problem.NumResidualBlocks() == 0) return poses;
  double* const anchor = values[fixed].data();
  if (problem.HasParameterBlock(anchor)) problem.SetParameterBlockConstant(anchor);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-16;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (static_cast<int>(k) == fixed || !problem.HasParameterBlock(values[k].data())) continue;
    poses[k] = {rotation_of(Eigen::Map<Vec3>(values[k].data())), Eigen::Map<Vec3>(values[k].data() + 3)};
  }
  return poses;
}

Matrix6 adjoint(const RigidTransform& a_from_b) {
  Eigen::Matrix3d cross;
  const Vec3& t = a_from_b.translation;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  Matrix6 a = Matrix6::Zero();
  a.topLeftCorner<3, 3>() = a_from_b.rotation;
  a.bottomRightCorner<3, 3>() = a_from_b.rotation;
  a.bottomLeftCorner<3, 3>() = cross * a_from_b.rotation;
  return a;
}

std::vector<Matrix6> pose_covariances(std::span<const RigidTransform> world_from_scan, std::span<const PoseEdge> edges,
                                      int fixed) {
  const auto n = static_cast<Eigen::Index>(6 * world_from_scan.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  for (const PoseEdge& edge : edges) {
    const Matrix6 to_target = adjoint(world_from_scan[edge.target].inverse());
    const Matrix6 block = to_target.transpose() * edge.information * to_target;
    const Eigen::Index i = 6 * edge.target, j = 6 * edge.source;
    normal.block<6, 6>(i, i) += block;
    normal.block<6, 6>(j, j) += block;
    normal.block<6, 6>(i, j) -= block;
    normal.block<6, 6>(j, i) -= block;
  }
  normal.middleRows<6>(6 * fixed).setZero();
  normal.middleCols<6>(6 * fixed).setZero();
  const SymmetricEigen<Eigen::MatrixXd> solver = symmetric_eigen(normal);
  Eigen::VectorXd inverse = solver.values;
  const double most = inverse.maxCoeff();
  for (double& value : inverse) value = value > kFree * most ? 1.0 / value : 0.0;
  const Eigen::MatrixXd covariance = solver.vectors * inverse.asDiagonal() * solver.vectors.transpose();
  std::vector<Matrix6> blocks;
  for (Eigen::Index k = 0; k < n; k += 6) blocks.emplace_back(covariance.block<6, 6>(k, k));
  return blocks;
}

}  // namespace patinate::capture
