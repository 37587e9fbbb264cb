/// \file
/// Decompositions of dense matrices, compiled once: each costs seconds in every source that instantiates it. All are
/// Eigen's own. They lie in dense_eigen.cpp, dense_ldlt.cpp and dense_solve.cpp: in one, they would
/// take 2 GB of memory to compile.
#pragma once

#include <Eigen/Core>
#include <memory>

namespace patinate {

/// Eigenvalues and vectors of a symmetric n x n matrix.
template <class Matrix>
struct SymmetricEigen {
  Eigen::Matrix<typename Matrix::Scalar, Matrix::RowsAtCompileTime, 1> values;  ///< n, ascending.
  Matrix vectors;             ///< n x n; column k belongs to values[k]; orthonormal.
  bool is_converged = false;  ///< Otherwise nothing is known of the others; so too when the matrix is not finite.
};

/// Eigenvalues and eigenvectors by the QR algorithm. @param matrix  n x n, n >= 1; only its lower triangle is read.
[[nodiscard]] SymmetricEigen<Eigen::MatrixXd> symmetric_eigen(const Eigen::MatrixXd& matrix);
[[nodiscard]] SymmetricEigen<Eigen::MatrixXf> symmetric_eigen(const Eigen::MatrixXf& matrix);
[[nodiscard]] SymmetricEigen<Eigen::Matrix<double, 6, 6>> symmetric_eigen(const Eigen::Matrix<double, 6, 6>& matrix);
[[nodiscard]] SymmetricEigen<Eigen::Matrix3d> symmetric_eigen(const Eigen::Matrix3d& matrix);
[[nodiscard]] SymmetricEigen<Eigen::Matrix2d> symmetric_eigen(const Eigen::Matrix2d& matrix);

/// Eigenvalues alone, n, ascending: by another path than symmetric_eigen(), whose last bits may differ.
/// @param matrix  n x n, n >= 1, symmetric; only its lower triangle is read.
[[nodiscard]] Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& matrix);

/// Solution of matrix x = right by L D L^T with pivots; not finite, or of any values, where the matrix is singular.
/// @param matrix  n x n, symmetric and semidefinite; only its lower triangle is read.
/// @param right   n, or n x m.
[[nodiscard]] Eigen::VectorXd solve_ldlt(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);
[[nodiscard]] Eigen::MatrixXd solve_ldlt(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right);
[[nodiscard]] Eigen::Matrix<double, 6, 1> solve_ldlt(const Eigen::Matrix<double, 6, 6>& matrix,
                                                     const Eigen::Matrix<double, 6, 1>& right);
[[nodiscard]] Eigen::Vector4d solve_ldlt(const Eigen::Matrix4d& matrix, const Eigen::Vector4d& right);
[[nodiscard]] Eigen::Vector3d solve_ldlt(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& right);

/// Works as solve_ldlt(), for several right sides, or for who asks how near to singular a matrix is.
class LdltFactors {
 public:
  /// @param matrix  n x n, n >= 1, symmetric and semidefinite; only its lower triangle is read.
  explicit LdltFactors(const Eigen::MatrixXd& matrix);
  ~LdltFactors();
  LdltFactors(const LdltFactors&) = delete;
  LdltFactors& operator=(const LdltFactors&) = delete;

  /// Whether the matrix could be factored.
  [[nodiscard]] bool is_factored() const;
  /// The least element of D.
  [[nodiscard]] double least_pivot() const;
  /// @param right  n, or n x m. @returns as many.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right) const;
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

/// Solution of matrix x = right by LU with pivots of its rows; not finite where the matrix is singular.
/// @param matrix  n x n. @param right  n.
[[nodiscard]] Eigen::VectorXd solve_lu(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);
/// By the same. @param matrix  n x n, n >= 1.
[[nodiscard]] Eigen::MatrixXd inverse_by_lu(const Eigen::MatrixXd& matrix);
/// Shortest x with the least |matrix x - right|, by a complete orthogonal decomposition, for any rank.
/// @param matrix  m x n. @param right  m, or m x k. @returns n, or n x k.
[[nodiscard]] Eigen::VectorXd shortest_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);
[[nodiscard]] Eigen::MatrixXd shortest_least_squares(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right);

/// Right singular vectors of an m x n matrix.
struct RightSingular {
  Eigen::VectorXd values;   ///< min(m, n), descending.
  Eigen::MatrixXd vectors;  ///< n x n; column k belongs to values[k], the last ones to none; orthonormal.
};
/// By Jacobi's rotations. @param matrix  m x n.
[[nodiscard]] RightSingular right_singular(const Eigen::MatrixXd& matrix);

/// The orthonormal matrix nearest to one in the least-squares sense, U V^T of its singular values; det +1 where the
/// matrix' is positive.
[[nodiscard]] Eigen::Matrix3d nearest_orthonormal(const Eigen::Matrix3d& matrix);

/// n x k with orthonormal columns that span those of the matrix, by Householder's reflections.
/// @param columns  n x k, k <= n, of full rank.
[[nodiscard]] Eigen::MatrixXf orthonormal_columns(const Eigen::MatrixXf& columns);

}  // namespace patinate
