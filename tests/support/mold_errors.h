/// \file
/// How far a history that was made of the mold is from its truth.
#pragma once

#include <filesystem>

namespace patinate::testing_support {

struct MoldErrors {
  // Over all texels and channels that the history and the frame call valid, of all frames:
  double albedo_rms = 0.0;     ///< Root mean square error over root mean square of the truth.
  double albedo_median = 0.0;  ///< Median of |error| / truth.
  double albedo_p95 = 0.0;
  double albedo_worst = 0.0;
  double valid_share = 0.0;        ///< Share of the object's texels.
  double normal_median_deg = 0.0;  ///< Median angle of the frames' normals.
  // On the lacquered spot, where nothing changes:
  double spot_drift =
      0.0;  ///< Largest difference of its mean albedo in a frame from that in all frames, over the latter.
  double spot_texel_drift = 0.0;  ///< Median over its texels of the standard deviation over time, over the mean.
  double pose_mm = 0.0;           ///< Largest displacement that the poses' errors cause there.
  double accessibility_correlation = 0.0;  ///< Correlation of ranks with the curvature that the patina followed.
};

/// @param data  Folder of plan_mold(); @param history  made of it.
[[nodiscard]] MoldErrors mold_errors(const std::filesystem::path& data, const std::filesystem::path& history);

}  // namespace patinate::testing_support
