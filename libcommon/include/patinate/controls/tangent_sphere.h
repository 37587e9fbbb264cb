/// \file
/// How hard a place is to reach, third definition: the largest sphere that touches it from outside.
#pragma once

#include <optional>

#include "patinate/controls/control_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Settings of tangent_sphere_map().
struct TangentSphereOptions {
  std::optional<double>
      largest_mm{};  ///< Radius at which it saturates; > 0. Not given: half of the bounding box's diagonal.
  double min_angle_deg =
      5.0;  ///< What rises less than this over the tangent plane does not stop the sphere; [0.1, 45].
  double full_percent = 99.0;  ///< This share of the area is at most what 1 stands for; [51, 100].
};
void describe(OptionVisitor& visitor, TangentSphereOptions& options);

/// 1 / radius of the largest sphere that is tangent at a point, outside, and holds no other point of the surface
/// [Miller 1994, "tangent-sphere accessibility"]: near a dihedral edge of angle phi, at distance d, the radius is d
/// tan(phi / 2). The radius of convex places is infinite and ends at `largest_mm`. Found by shrinking the sphere
/// against the points of a refined surface [Ma, Bae, Choi 2012, "3D medial axis point approximation using nearest
/// neighbors and the normal field"], about 0.4 % of the diagonal apart; what is nearer than 0.6 % is the point's own
/// surface, and does not stop it. Normals are those of the shape, not of the shading. Range: from 1 / largest_mm to the
/// `full_percent` percentile by area, "1/mm".
/// @throws InvalidInput if an option is out of range. Cost: some ten nearest-point queries a texel. Same bits for any
/// number of threads.
[[nodiscard]] ControlMap tangent_sphere_map(const TexelMap& map, const TangentSphereOptions& options = {},
                                            const RunControl& control = {});

}  // namespace patinate
