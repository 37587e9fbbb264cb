#include "transfer/exemplar/principal_components.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::transfer {

namespace {

using Index = Eigen::Index;
using Sums = std::vector<double>;

constexpr int kExtraColumns =
    8;  ///< Beyond those asked for: the wanted ones then converge by the gap to the first excluded.
/// Steps of orthogonal iteration; a fixed number, so that equal input gives equal bits.
constexpr int kIterations = 48;

Eigen::VectorXd mean_row(const SampleMatrix& samples) {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(samples.cols());
  for (Index i = 0; i < samples.rows(); ++i) {
    for (Index k = 0; k < samples.cols(); ++k) mean[k] += samples(i, k);
  }
  return mean / static_cast<double>(samples.rows());
}

/// n x n, row by row; the upper half is filled from the lower.
SampleMatrix covariance(const SampleMatrix& samples, const Eigen::VectorXd& mean, const RunControl& control) {
  const Index n = samples.cols();
  Sums total = parallel_reduce(
      samples.rows(), 512, control, Sums(),
      [&](std::int64_t begin, std::int64_t end) {
        Sums part(static_cast<std::size_t>(n * n), 0.0);
        std::vector<double> row(static_cast<std::size_t>(n));
        for (Index i = begin; i < end; ++i) {
          for (Index k = 0; k < n; ++k) row[k] = samples(i, k) - mean[k];
          for (Index a = 0; a < n; ++a) {
            const double value = row[a];
            double* out = part.data() + a * n;
            for (Index b = 0; b <= a; ++b) out[b] += value * row[b];
          }
        }
        return part;
      },
      [](Sums a, const Sums& b) {
        if (a.empty()) return b;
        for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
        return a;
      });
  SampleMatrix result(n, n);
  for (Index a = 0; a < n; ++a) {
    for (Index b = 0; b <= a; ++b) {
      result(a, b) = result(b, a) = total[a * n + b] / static_cast<double>(samples.rows());
    }
  }
  return result;
}

double dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  double sum = 0.0;
  for (Index i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

Eigen::VectorXd times(const SampleMatrix& matrix, const Eigen::VectorXd& v) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(matrix.rows());
  for (Index a = 0; a < matrix.rows(); ++a) {
    for (Index b = 0; b < matrix.cols(); ++b) result[a] += matrix(a, b) * v[b];
  }
  return result;
}

/// Modified Gram-Schmidt, twice; columns that vanish become zero.
void orthonormalize(std::vector<Eigen::VectorXd>& columns) {
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const double before = std::sqrt(dot(columns[k], columns[k]));
    for (int round = 0; round < 2; ++round) {
      for (std::size_t j = 0; j < k; ++j) columns[k] -= dot(columns[j], columns[k]) * columns[j];
    }
    const double length = std::sqrt(dot(columns[k], columns[k]));
    if (length > 1e-12 * before && length > 0.0) {
      columns[k] /= length;
    } else {
      columns[k].setZero();
    }
  }
}

/// Turns an orthonormal basis into eigenvectors of the matrix within its span, by falling eigenvalue [Rayleigh-Ritz].
std::vector<double> rotate_to_eigenvectors(const SampleMatrix& matrix, std::vector<Eigen::VectorXd>& columns) {
  const auto size = static_cast<Index>(columns.size());
  Eigen::MatrixXd small(size, size);
  for (Index b = 0; b < size; ++b) {
    const Eigen::VectorXd image = times(matrix, columns[b]);
    for (Index a = 0; a < size; ++a) small(a, b) = dot(columns[a], image);
  }
  // 16 x 16 at most: below the size at which Eigen works in blocks.
  const SymmetricEigen<Eigen::MatrixXd> solver = symmetric_eigen(small);
  std::vector<Eigen::VectorXd> rotated;
  std::vector<double> values;
  for (Index k = size; k-- > 0;) {
    Eigen::VectorXd column = Eigen::VectorXd::Zero(matrix.rows());
    for (Index a = 0; a < size; ++a) column += solver.vectors(a, k) * columns[a];
    rotated.push_back(std::move(column));
    values.push_back(std::max(0.0, solver.values[k]));
  }
  columns = std::move(rotated);
  return values;
}

void fix_sign(Eigen::VectorXd& axis) {
  Index largest = 0;
  for (Index i = 1; i < axis.size(); ++i) {
    if (std::abs(axis[i]) > std::abs(axis[largest])) largest = i;
  }
  if (axis[largest] < 0.0) axis = -axis;
}

}  // namespace

PrincipalComponents principal_components(const SampleMatrix& samples, int count, const RunControl& control) {
  PrincipalComponents result;
  result.mean = mean_row(samples);
  const SampleMatrix matrix = covariance(samples, result.mean, control);
  const Index n = samples.cols();
  const Index num_columns = std::min<Index>(n, count + kExtraColumns);
  std::vector<Eigen::VectorXd> columns;
  for (Index k = 0; k < num_columns; ++k) {
    RandomStream random(0, static_cast<std::uint64_t>(k), 18);
    Eigen::VectorXd column(n);
    for (Index i = 0; i < n; ++i) column[i] = random.uniform() - 0.5;
    columns.push_back(std::move(column));
  }
  orthonormalize(columns);
  for (int i = 0; i < kIterations; ++i) {
    control.throw_if_stopped();
    for (Eigen::VectorXd& column : columns) column = times(matrix, column);
    orthonormalize(columns);
  }
  const std::vector<double> values = rotate_to_eigenvectors(matrix, columns);
  result.axes = Eigen::MatrixXd::Zero(n, count);
  double kept = 0.0, total = 0.0;
  for (Index k = 0; k < std::min<Index>(count, num_columns); ++k) {
    fix_sign(columns[k]);
    result.axes.col(k) = columns[k];
    kept += values[k];
  }
  for (Index i = 0; i < n; ++i) total += matrix(i, i);
  result.explained = total > 0.0 ? std::min(1.0, kept / total) : 1.0;
  return result;
}

}  // namespace patinate::transfer
