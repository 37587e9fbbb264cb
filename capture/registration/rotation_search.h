/// \file
/// The pose of one scan in another's frame when nothing is known about it.
#pragma once

#include <vector>

#include "capture/registration/prepared_scan.h"

namespace patinate::capture {

/// The 60 rotations of the icosahedron: none is more than 44.5 degrees away from the nearest.
[[nodiscard]] std::vector<Eigen::Matrix3d> icosahedral_rotations();

struct PoseCandidate {
  RigidTransform pose;  ///< Normalized, target from source.
  double score = 0.0;   ///< pose_score().
};
/// Overlap, times what does not lie in lines of sight (squared), times how closely the surfels fit for being `distance`
/// apart; [0, 1], larger is better.
[[nodiscard]] double pose_score(const SurfelAlignment& found, double in_front, double distance);
/// Coarse alignments from 60 rotations with the middles together and shifted, best first, near duplicates excluded;
/// `num_kept` at most. Same bits for any number of threads. @throws Canceled
[[nodiscard]] std::vector<PoseCandidate> search_poses(const PreparedScan& target, const PreparedScan& source,
                                                      int num_kept, const RunControl& control = {});

}  // namespace patinate::capture
