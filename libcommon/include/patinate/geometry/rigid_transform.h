/// \file
/// Rigid transforms, named target_from_source: x_in_target = target_from_source.apply(x_in_source), and inner names
/// cancel in a product.
#pragma once

#include <Eigen/Core>

#include "patinate/geometry/mesh.h"

namespace patinate {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct RigidTransform {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< Orthonormal, det +1.
  Vec3 translation = Vec3::Zero();

  [[nodiscard]] Vec3 apply(const Vec3& point) const { return rotation * point + translation; }
  [[nodiscard]] RigidTransform inverse() const;
  [[nodiscard]] Eigen::Matrix4d matrix() const;
};
/// c_from_b * b_from_a = c_from_a.
[[nodiscard]] RigidTransform operator*(const RigidTransform& left, const RigidTransform& right);

/// Makes a transform from a 4 x 4 matrix; its rotation becomes the nearest orthonormal one. (@throws unchanged.)
[[nodiscard]] RigidTransform rigid_transform(const Eigen::Matrix4d& matrix);
/// Rotation by |axis_angle| radians about axis_angle [Rodrigues]; exact to rounding for small angles too.
[[nodiscard]] Eigen::Matrix3d rotation_of(const Vec3& axis_angle);
/// The inverse of rotation_of(), of length [0, pi].
[[nodiscard]] Vec3 axis_angle_of(const Eigen::Matrix3d& rotation);
/// Angle between two rotations, degrees, [0, 180].
[[nodiscard]] double angle_between_deg(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

}  // namespace patinate
