/// \file
/// All scans of an object in the frame of one of them, so that errors do not add up along the chain.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "patinate/capture/registration.h"

namespace patinate::capture {

/// Two scans that overlap.
struct RegistrationEdge {
  int target = 0;
  int source = 0;
  PairRegistration pair;    ///< Result of the two scans alone; Converged or Degenerate.
  bool is_in_tree = false;  ///< The chain by which the poses were begun.
  bool is_used = true;      ///< false: it contradicts all others, and was excluded.
  double closure_deg =
      0.0;  ///< Edges outside the tree: the pair alone against the way through the tree, before the joint solve:
  double closure = 0.0;          ///< angle, and shift of the source's middle.
  double median_residual = 0.0;  ///< After the joint solve: median distance of partners along the normal.
};

struct RegisteredScan {
  RegistrationStatus status = RegistrationStatus::TooFewPairs;
  RigidTransform reference_from_scan;
  int partner = -1;           ///< Scan that it overlaps most with; -1 = none.
  double overlap = 0.0;       ///< With it.
  double rms_residual = 0.0;  ///< Over all its edges, in the joint poses.
  /// Covariance of (rotation in radians, shift) about `center`; 0 for the reference. As in PairRegistration, and what
  /// the pose would move by were the changed share misjudged, where it overlaps with the reference.
  Matrix6 covariance = Matrix6::Zero();
  double staying = 1.0;  ///< Staying as in PairRegistration, since the reference; 1 where the two do not overlap.
  /// The pose fits, but most of the surface has changed, and nothing tells which part has not (is_misled_by_change());
  /// `status` is PoorFit then.
  bool is_misled = false;
  Vec3 center = Vec3::Zero();                        ///< The scan's middle in the reference's frame.
  std::vector<UnconstrainedDof> unconstrained_dofs;  ///< In the reference's frame.
  bool is_found_by_search = false;
  double ambiguous_deg = 0.0;  ///< Of the pair that placed it first, as in PairRegistration.
};

struct JointRegistration {
  std::vector<RegisteredScan> scans;
  std::vector<RegistrationEdge> edges;  ///< In the order (target, source).
  double largest_closure_deg = 0.0;
  double largest_closure = 0.0;
  double median_closure_deg = 0.0;
  double median_closure = 0.0;
  int num_rounds = 0;  ///< Number of rounds of finding partners again and solving.
};

/// Each scan is first registered to those that have a pose already, the reference first (from its initial pose, else
/// from the reference's frame, else by search); then every pair that overlaps in these poses is registered, and all
/// poses are solved for together with Ceres (pose_graph.h): first on the pairs' results, then on the pairs' normal
/// equations in the joint poses, with new partners, until nothing moves. A scan that fits none keeps its start and says
/// why. With a PCL method the pairs come from PCL, and no round follows.
/// @param scans      At least 2, in one unit. @param initial  world from scan: as many as scans, or none. A scan
/// without one may stand anywhere.
/// @param reference  In [0, scans).
/// @throws InvalidInput; Canceled
[[nodiscard]] JointRegistration register_jointly(std::span<const PointCloud> scans,
                                                 std::span<const std::optional<RigidTransform>> initial, int reference,
                                                 const RegistrationOptions& options = {},
                                                 const RunControl& control = {});

}  // namespace patinate::capture
