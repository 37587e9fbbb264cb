#include "transfer/exemplar/principal_components.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "libcommon/core/random.h"

namespace patinate::transfer {
namespace {

/// m samples in n dimensions whose spread falls by `ratio` from axis to axis of a random rotation.
SampleMatrix random_samples(int m, int n, double ratio) {
  RandomStream random(11, 0);
  Eigen::MatrixXd mixing(n, n);
  for (int i = 0; i < n * n; ++i) mixing.data()[i] = random.normal();
  const Eigen::MatrixXd rotation = Eigen::HouseholderQR<Eigen::MatrixXd>(mixing).householderQ();
  SampleMatrix samples(m, n);
  for (int i = 0; i < m; ++i) {
    Eigen::VectorXd v(n);
    double spread = 10.0;
    for (int k = 0; k < n; ++k, spread *= ratio) v[k] = spread * random.normal();
    samples.row(i) = (rotation * v).transpose().array() + 3.0;
  }
  return samples;
}

TEST(PrincipalComponents, AgreeWithADenseEigenSolver) {
  const SampleMatrix samples = random_samples(2000, 40, 0.7);
  const PrincipalComponents found = principal_components(samples, 8);
  const Eigen::MatrixXd centered = samples.rowwise() - samples.colwise().mean();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(centered.transpose() * centered / 2000.0);
  double kept = 0.0;
  for (int k = 0; k < 8; ++k) {
    const Eigen::VectorXd axis = solver.eigenvectors().col(39 - k);
    EXPECT_NEAR(std::abs(axis.dot(found.axes.col(k))), 1.0, 1e-9) << k;
    kept += solver.eigenvalues()[39 - k];
  }
  EXPECT_NEAR(found.explained, kept / solver.eigenvalues().sum(), 1e-12);
}

TEST(PrincipalComponents, OfFewerDimensionsThanAskedForKeepEverything) {
  const PrincipalComponents found = principal_components(random_samples(100, 3, 0.5), 8);
  EXPECT_NEAR(found.explained, 1.0, 1e-12);
  EXPECT_EQ(found.axes.rightCols(5).norm(), 0.0);
}

TEST(PrincipalComponents, OfAConstantAreZeroAndFinite) {
  const PrincipalComponents found = principal_components(SampleMatrix::Constant(50, 12, 0.3), 8);
  EXPECT_EQ(found.explained, 1.0);
  EXPECT_TRUE(found.axes.allFinite());
}

// Eigen cuts its matrix products by the processor's caches; our bits must not follow.
TEST(PrincipalComponents, DoNotDependOnTheProcessorsCaches) {
  std::ptrdiff_t l1 = 0, l2 = 0, l3 = 0;
  Eigen::internal::manage_caching_sizes(Eigen::GetAction, &l1, &l2, &l3);
  const SampleMatrix samples = random_samples(3000, 120, 0.95);
  const PrincipalComponents here = principal_components(samples, 8);
  for (std::ptrdiff_t other : {16 * 1024, 64 * 1024}) {
    Eigen::setCpuCacheSizes(other, 8 * other, 64 * other);
    const PrincipalComponents there = principal_components(samples, 8);
    EXPECT_EQ(here.axes, there.axes);
    EXPECT_EQ(here.explained, there.explained);
  }
  Eigen::setCpuCacheSizes(l1, l2, l3);
}

}  // namespace
}  // namespace patinate::transfer
