#include "patinate/geometry/rigid_transform.h"

#include <Eigen/Geometry>
#include <cmath>

#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate {

RigidTransform RigidTransform::inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }

Eigen::Matrix4d RigidTransform::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation;
  m.topRightCorner<3, 1>() = translation;
  return m;
}

RigidTransform operator*(const RigidTransform& left, const RigidTransform& right) {
  return {left.rotation * right.rotation, left.rotation * right.translation + left.translation};
}

RigidTransform rigid_transform(const Eigen::Matrix4d& matrix) {
  constexpr double kTolerance = 1e-4;
  if (!matrix.allFinite()) throw InvalidInput("a transform holds numbers that are not finite");
  if (!(matrix.row(3) - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).isZero(kTolerance)) {
    throw InvalidInput("the last row of a transform is not 0 0 0 1");
  }
  const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
  if (linear.determinant() < 0.0) throw InvalidInput("a transform mirrors; a rotation and a translation are expected");
  if (!(linear * linear.transpose() - Eigen::Matrix3d::Identity()).isZero(kTolerance)) {
    throw InvalidInput("a transform scales or shears; a rotation and a translation are expected");
  }
  return {nearest_orthonormal(linear), matrix.topRightCorner<3, 1>()};
}

Eigen::Matrix3d rotation_of(const Vec3& axis_angle) {
  const double angle = axis_angle.norm();
  // sin(angle / 2) / angle, whose limit at 0 is 1/2; the next term is below rounding there.
  const double factor = angle > 1e-8 ? std::sin(0.5 * angle) / angle : 0.5;
  const Vec3 v = factor * axis_angle;
  return Eigen::Quaterniond(std::cos(0.5 * angle), v.x(), v.y(), v.z()).normalized().toRotationMatrix();
}

Vec3 axis_angle_of(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  const double factor = sine > 1e-8 ? 2.0 * std::atan2(sine, q.w()) / sine : 2.0;
  return factor * q.vec();
}

double angle_between_deg(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return axis_angle_of(a.transpose() * b).norm() * 180.0 / 3.14159265358979323846;
}

}  // namespace patinate
