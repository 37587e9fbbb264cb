/// \file
/// Leading principal components, with equal bits for equal input (tested on x86-64).
#pragma once

#include <Eigen/Core>

#include "patinate/core/run_control.h"

namespace patinate::transfer {

/// Samples as rows.
using SampleMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct PrincipalComponents {
  Eigen::VectorXd mean;    ///< n
  Eigen::MatrixXd axes;    ///< n x count, orthonormal, by falling variance; zero columns when n < count. The largest
                           ///< entry of each is positive.
  double explained = 1.0;  ///< Share of the samples' variance that the axes keep, in [0, 1].
};

/// By orthogonal iteration on the covariance [Golub and Van Loan, sec. 8.2.4] from a fixed start. Uses + - * / and sqrt
/// in a fixed order, and none of Eigen's products whose blocking follows the processor's caches: same bits for any
/// number of threads (tested on x86-64). Axes whose variances nearly agree may be mixed with one another: only the
/// space that they span matters here.
/// @param samples  m x n, m > 0, finite. Cost: O(m n^2).
[[nodiscard]] PrincipalComponents principal_components(const SampleMatrix& samples, int count,
                                                       const RunControl& control = {});

}  // namespace patinate::transfer
