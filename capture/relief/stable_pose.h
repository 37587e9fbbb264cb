/// \file
/// Where a scan stands, by the part of the surface that has not changed: a change of the rest must not be absorbed.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/geometry/rigid_transform.h"

namespace patinate::capture {

/// A small motion of a scan: (rotation in radians, shift) about a point. What it raises the surface by over a place,
/// along a unit normal, is the row's product with it.
[[nodiscard]] inline Vec6 raising_row(const Vec3& place_from_center, const Vec3& normal) {
  Vec6 row;
  row << place_from_center.cross(normal), normal;
  return row;
}

/// Height of a scan over the reference, at one place or in the mean of several.
struct HeightDifference {
  Vec6 row = Vec6::Zero();  ///< raising_row(), or a mean of several.
  double change = 0.0;      ///< Along the normal.
  double variance = 0.0;    ///< > 0. Places that share no points, so that they are independent.
};

struct StablePose {
  Vec6 motion = Vec6::Zero();  ///< Brings the scan to the reference.
  Matrix6 covariance =
      Matrix6::Zero();        ///< Covariance of the pose; 0 in degrees of freedom that heights do not constrain.
  int num_dofs = 0;           ///< That heights constrain.
  double agreeing = 0.0;      ///< Share of the differences that the pose explains, within 3 standard deviations.
  double noise_factor = 1.0;  ///< Standard deviation of those, over the stated one; robust.
};

/// Robust standard deviation of what is no outlier, from absolute values: 1.4826 times their median, again without what
/// lies beyond 2.5 of it, until it stays. Where a third has changed, the first is half too large.
[[nodiscard]] double inner_scale(std::vector<double> sizes);

/// The small motion after which most places show no change: least trimmed squares over half of the differences, from
/// 500 draws of as many as there are degrees of freedom [Rousseeuw, Van Driessen 2006, FAST-LTS], then Tukey's biweight
/// on what is left. Holds as long as more than half of the places have not changed; `agreeing` says how many agree.
/// Degrees of freedom in which the surface slides along itself stay as they are (a plate's shifts in its plane).
/// @param size  Of the surface about the center of the rows, > 0: what makes turns and shifts comparable.
/// @throws InvalidInput with fewer than 12 differences.
[[nodiscard]] StablePose find_stable_pose(std::span<const HeightDifference> differences, double size,
                                          std::uint64_t seed = 1);

}  // namespace patinate::capture
