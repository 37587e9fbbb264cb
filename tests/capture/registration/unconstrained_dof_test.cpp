#include "capture/registration/unconstrained_dof.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace patinate::capture {
namespace {

using Directions = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Columns mixed among each other, as an eigen decomposition gives them.
Directions mixed(const Directions& basis) {
  Eigen::MatrixXd mix = Eigen::MatrixXd::Random(basis.cols(), basis.cols());
  const Directions all = basis * mix;
  return Eigen::HouseholderQR<Eigen::MatrixXd>(all).householderQ() * Eigen::MatrixXd::Identity(6, basis.cols());
}

TEST(UnconstrainedDof, APlaneHasTwoShiftsAndATurn) {
  Directions basis = Directions::Zero(6, 3);
  basis(3, 0) = basis(4, 1) = basis(2, 2) = 1.0;
  const auto motions = unconstrained_dofs(mixed(basis));
  ASSERT_EQ(motions.size(), 3u);
  EXPECT_EQ(motions[0].kind, UnconstrainedDof::Kind::Shift);
  EXPECT_EQ(motions[1].kind, UnconstrainedDof::Kind::Shift);
  EXPECT_NEAR(motions[0].direction.cross(motions[1].direction).cross(Vec3(0, 0, 1)).norm(), 0.0, 1e-9);
  EXPECT_EQ(motions[2].kind, UnconstrainedDof::Kind::Turn);
  EXPECT_NEAR((motions[2].direction - Vec3(0, 0, 1)).norm(), 0.0, 1e-9);
}

TEST(UnconstrainedDof, ACylinderTurnsAboutItsAxisAndSlidesAlongIt) {
  // Axis along x through (0, 2, 3): points p turn by x times (p - (0, 2, 3)).
  Directions basis = Directions::Zero(6, 2);
  basis.col(0) << 1, 0, 0, -Vec3(1, 0, 0).cross(Vec3(0, 2, 3));
  basis(3, 1) = 1.0;
  const auto motions = unconstrained_dofs(mixed(basis));
  ASSERT_EQ(motions.size(), 2u);
  EXPECT_EQ(text_of(motions[0]), "shift along (1, 0, 0)");
  EXPECT_EQ(text_of(motions[1]), "turn about (1, 0, 0) through (0, 2, 3)");
}

TEST(UnconstrainedDof, ASphereTurnsAboutItsMiddle) {
  const Vec3 middle(0.5, -1, 0.25);
  Directions basis = Directions::Zero(6, 3);
  for (int k = 0; k < 3; ++k) basis.col(k) << Vec3::Unit(k), -Vec3::Unit(k).cross(middle);
  const auto motions = unconstrained_dofs(mixed(basis));
  ASSERT_EQ(motions.size(), 3u);
  for (const UnconstrainedDof& m : motions) {
    EXPECT_EQ(m.kind, UnconstrainedDof::Kind::Turn);
    EXPECT_NEAR((middle - m.point).cross(m.direction).norm(), 0.0, 1e-9) << "the axis passes through the middle";
    EXPECT_EQ(m.pitch, 0.0);
  }
}

}  // namespace
}  // namespace patinate::capture
