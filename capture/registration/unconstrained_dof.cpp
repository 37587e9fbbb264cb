#include "capture/registration/unconstrained_dof.h"

#include <Eigen/Geometry>
#include <cmath>

#include "libcommon/core/text.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::capture {

namespace {

constexpr double kSmall = 1e-3;      ///< Share of a vector's length: shown as 0.
constexpr double kNoRotation = 0.1;  ///< Rotation part of a unit direction below which it is a shift.

std::string vector_text(const Vec3& v) {
  std::string text = "(";
  for (int k = 0; k < 3; ++k) {
    const double value = std::abs(v[k]) < kSmall * v.norm() ? 0.0 : v[k];
    text += (k == 0 ? "" : ", ") + short_number_text(rounded(value, 3));
  }
  return text + ")";
}

/// The first component that is not small is positive: one name for one axis.
Vec3 with_sign(const Vec3& v) {
  for (int k = 2; k >= 0; --k) {
    if (std::abs(v[k]) > 0.1) return v[k] < 0.0 ? Vec3(-v) : v;
  }
  return v;
}

}  // namespace

std::string text_of(const UnconstrainedDof& motion) {
  if (motion.kind == UnconstrainedDof::Kind::Shift) return "shift along " + vector_text(motion.direction);
  const std::string text = "turn about " + vector_text(motion.direction) + " through " + vector_text(motion.point);
  return motion.pitch == 0.0
             ? text
             : text + " with a shift of " + short_number_text(rounded(motion.pitch, 3)) + " along it per radian";
}

std::vector<UnconstrainedDof> unconstrained_dofs(const Eigen::Matrix<double, 6, Eigen::Dynamic>& directions) {
  std::vector<UnconstrainedDof> motions;
  if (directions.cols() == 0) return motions;
  // Rotations of the span, largest first; what has none of it left is a shift.
  const Eigen::Matrix<double, 3, Eigen::Dynamic> turns = directions.topRows<3>();
  const RightSingular svd = right_singular(turns);
  std::vector<Vec3> shifts;
  const Eigen::Index num = directions.cols();
  const auto value = [&](Eigen::Index k) { return k < svd.values.size() ? svd.values[k] : 0.0; };
  for (Eigen::Index k = num - 1; k >= 0 && value(k) < kNoRotation; --k) {
    Vec3 shift = directions.bottomRows<3>() * svd.vectors.col(k);
    for (const Vec3& other : shifts) shift -= other * other.dot(shift);
    if (!(shift.norm() > 1e-6)) continue;
    shifts.push_back(shift.normalized());
    motions.push_back({UnconstrainedDof::Kind::Shift, with_sign(shift.normalized())});
  }
  for (Eigen::Index k = 0; k < num && value(k) >= kNoRotation; ++k) {
    const Vec6 twist = directions * svd.vectors.col(k);
    const Vec3 axis = twist.head<3>();
    Vec3 shift = twist.tail<3>();
    for (const Vec3& other : shifts) shift -= other * other.dot(shift);
    UnconstrainedDof turn;
    turn.kind = UnconstrainedDof::Kind::Turn;
    turn.direction = with_sign(axis.normalized());
    turn.point = axis.cross(shift) / axis.squaredNorm();
    const double pitch = axis.dot(shift) / axis.squaredNorm();
    if (std::abs(pitch) > 0.1 * shift.norm() / axis.norm() && std::abs(pitch) > 1e-6) turn.pitch = pitch;
    motions.push_back(turn);
  }
  return motions;
}

}  // namespace patinate::capture
