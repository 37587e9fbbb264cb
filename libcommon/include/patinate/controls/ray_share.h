/// \file
/// How hard a place is to reach, second definition: the share of rays that hit the object again.
#pragma once

#include <optional>

#include "patinate/controls/control_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Settings of ray_share_map().
struct RayShareOptions {
  int num_rays = 256;                ///< Rays over the hemisphere of a point; [16, 4096].
  std::optional<double> reach_mm{};  ///< Length of the rays; > 0. Not given: 10 % of the bounding box's diagonal.
};
void describe(OptionVisitor& visitor, RayShareOptions& options);

/// The share of rays from a point, cosine-weighted over the hemisphere about its normal, that hit the object again
/// within `reach_mm` (ambient obscurance with a hard end [Zhukov et al. 1998]): 0 on what is convex, 1 in a closed
/// pocket. Unlike mean curvature it sees parts that only stand near each other. Range [0, 1] "share".
/// @throws InvalidInput if an option is out of range. Cost: as exposure_map(). Same bits for any number of threads.
[[nodiscard]] ControlMap ray_share_map(const TexelMap& map, const RayShareOptions& options = {},
                                       const RunControl& control = {});

}  // namespace patinate
