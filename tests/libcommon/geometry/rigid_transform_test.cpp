#include "patinate/geometry/rigid_transform.h"

#include <gtest/gtest.h>

#include <cmath>

#include "patinate/core/error.h"

namespace patinate {
namespace {

constexpr double kTurnRounding = 1e-14;

TEST(RigidTransform, InverseUndoesItAndProductsChain) {
  const RigidTransform b_from_a{rotation_of({0.3, -1.2, 0.7}), {10, -20, 5}};
  const RigidTransform c_from_b{rotation_of({-2.0, 0.1, 0.4}), {1, 2, 3}};
  const Vec3 p(4, 5, -6);
  EXPECT_LT((b_from_a.inverse().apply(b_from_a.apply(p)) - p).norm(), 100 * kTurnRounding);
  EXPECT_LT(((c_from_b * b_from_a).apply(p) - c_from_b.apply(b_from_a.apply(p))).norm(), 100 * kTurnRounding);
  EXPECT_LT((rigid_transform(b_from_a.matrix()).rotation - b_from_a.rotation).norm(), 10 * kTurnRounding);
}

TEST(RigidTransform, AxisAngleGoesThereAndBackFromTheSmallestToHalfATurn) {
  for (double angle : {1e-12, 1e-9, 1e-5, 0.1, 1.0, 3.0, 3.14159}) {
    const Vec3 v = angle * Vec3(2, -1, 0.5).normalized();
    EXPECT_LT((axis_angle_of(rotation_of(v)) - v).norm(), 1e-9 * angle + kTurnRounding) << angle;
    EXPECT_NEAR(angle_between_deg(Eigen::Matrix3d::Identity(), rotation_of(v)), angle * 180 / M_PI, 1e-10);
  }
}

TEST(RigidTransform, MirrorsShearsAndProjectionsAreRefused) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m(0, 0) = -1;
  EXPECT_THROW((void)rigid_transform(m), InvalidInput);
  m(0, 0) = 1.01;
  EXPECT_THROW((void)rigid_transform(m), InvalidInput);
  m(0, 0) = std::nan("");
  EXPECT_THROW((void)rigid_transform(m), InvalidInput);
  m = Eigen::Matrix4d::Identity();
  m(3, 0) = 1;
  EXPECT_THROW((void)rigid_transform(m), InvalidInput);
}

}  // namespace
}  // namespace patinate
