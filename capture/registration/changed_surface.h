/// \file
/// How far a pose depends on which part of the surface has stayed.
#pragma once

#include "capture/registration/prepared_scan.h"

namespace patinate::capture {

/// Evidence of a change between two scans in a pose.
struct ChangedSurface {
  double staying = 1.0;  ///< Share of the partners that are no farther apart than the points' own scatter makes them.
  /// Motion of the pose, (rotation in radians, shift) about the target's middle in the scans' unit, were only
  /// the part of the surface unchanged that is most likely so: the half (or what stays, if that is less, a tenth at
  /// least) that lies lowest or highest in the source, whichever is the more even. As far as distances are more than
  /// the points' scatter: 0 for a surface that stays.
  Vec6 misjudged = Vec6::Zero();

  /// Where less than this share stays, the larger part of the surface has changed, and what of it has stayed is told by
  /// nothing: a pose that fits most of it takes the change for motion.
  static constexpr double kMinStaying = 0.4;
  /// Shift by which a pose may be off for this and still be one, in distances between points: a quarter, as scans may
  /// be off each other where they fit.
  static constexpr double kMaxMisjudged = 0.25;
};

/// Says whether a pose is none because the surface has changed: less than ChangedSurface::kMinStaying stay, and the
/// pose moves by more than ChangedSurface::kMaxMisjudged with what is taken for unchanged.
/// @param spacing  Of the points; in the unit of `misjudged`.
[[nodiscard]] bool is_misled_by_change(double staying, const Vec6& misjudged, double spacing);

/// Growth and loss lie to one side, so that what has stayed lies at the other end: least trimmed squares, one-sided.
/// Partners are the nearest in the target of every surfel of the source, facing alike; parts are those of the signed
/// distances along the normals.
/// @param pose  target from source, normalized. Of fewer than 30 partners nothing is told: all stays.
[[nodiscard]] ChangedSurface look_for_change(const PreparedScan& target, const PreparedScan& source,
                                             const RigidTransform& pose, const RunControl& control = {});

}  // namespace patinate::capture
