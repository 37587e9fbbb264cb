/// \file
/// From differences of heights at places to maps with deviations, what is significant, and volumes. Inside of relief
/// only.
#pragma once

#include <vector>

#include "capture/relief/relief_change.h"
#include "capture/relief/stable_pose.h"

namespace patinate::capture {

/// Difference at one place: how much higher a scan lies than the reference, and how well the points alone tell it.
struct PlaceDifference {
  double change = 0.0;
  double variance = 0.0;
  bool is_measured = false;
};

/// Facts of a scan beside the differences.
struct ChangeModel {
  Matrix6 pose_covariance = Matrix6::Zero();  ///< About `center`.
  Vec3 center = Vec3::Zero();
  double noise_factor = 1.0;
  double systematic_mm = 0.0;
  int systematic_block = 1;    ///< Pixels over which the systematic part is the same.
  double window_pixels = 1.0;  ///< Area of a window: neighbors so far share points.
};

/// Fills maps, shares and volumes. Significant is what the procedure of Benjamini and Hochberg [1995] finds at
/// `false_share`; the variance of a volume holds that neighbors share points, that the scan's place moves all of them,
/// and that the systematic part moves a block.
void fill_change(ReliefChange& change, const ReliefView& view, const std::vector<ReliefPlace>& places,
                 const std::vector<PlaceDifference>& differences, const ChangeModel& model, double false_share);

/// The largest p value that is significant among these, so that at most `false_share` of what is found is false on the
/// mean; 0 = none is. @param p  In [0, 1].
[[nodiscard]] double significant_p(std::vector<double> p, double false_share);

}  // namespace patinate::capture
