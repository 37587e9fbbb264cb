/// \file
/// How hard a place is to reach, by three definitions: mean curvature of the surface at a physical scale, the share of
/// rays that hit the object again, and the largest sphere that touches the place from outside.
#pragma once

#include <optional>
#include <vector>

#include "patinate/controls/control_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Settings of accessibility_map().
struct AccessibilityOptions {
  std::optional<double>
      scale_mm;  ///< Gaussian width of what counts as one feature; > 0. Not given: 2 % of the box's diagonal.
  double low_percent = 1.0;    ///< This share of the area is at most what 0 stands for; [0, 49].
  double high_percent = 99.0;  ///< This share of the area is at most what 1 stands for; [51, 100].
};
void describe(OptionVisitor& visitor, AccessibilityOptions& options);

/// The scale that is used when none is given: 2 % of the bounding box's diagonal.
[[nodiscard]] double default_accessibility_scale_mm(const Mesh& mesh);

/// A mesh without its facets, with its curvature.
struct AccessibleSurface {
  Mesh mesh;                             ///< Refined to edges of at most half the scale, curved (RefineShape::Curved).
  std::vector<double> curvature_per_mm;  ///< At its positions; concave positive.
  double scale_mm = 0.0;
};
/// What accessibility_map() stands on, for surfaces without an atlas.
/// @param mesh  In mm. @param scale_mm  > 0; not given: default_accessibility_scale_mm().
/// @throws InvalidInput if the scale is not positive or the mesh has no area.
[[nodiscard]] AccessibleSurface accessible_surface(const Mesh& mesh, std::optional<double> scale_mm,
                                                   const RunControl& control = {});
/// Widens a range to at least 0.001 / scale, so that a plane or a sphere gives an even map instead of noise.
[[nodiscard]] ValueRange widened_accessibility_range(ValueRange range, double scale_mm);

/// Mean curvature at a scale, concave high: crevices are 1, ridges and tips 0 [Miller 1994, in the form of
/// mean_curvature()].
///
/// The mesh is refined to edges of at most half the scale (and at most 1,000,000 triangles), curved as its shading
/// normals ask for, so that facets do not show; its curvature is found at the positions and interpolated to the texels.
/// Range: percentiles by area, in 1/mm, at least 0.001 / scale wide, so that a plane or a sphere is even and not noise.
/// Parts that only touch or pass through each other do not see each other.
/// @throws InvalidInput if an option is out of range or the mesh has no area.
/// Cost: about 1 s for 100,000 triangles. Same bits for any number of threads.
[[nodiscard]] ControlMap accessibility_map(const TexelMap& map, const AccessibilityOptions& options = {},
                                           const RunControl& control = {});

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

/// Settings of tangent_sphere_map().
struct TangentSphereOptions {
  std::optional<double>
      largest_mm{};  ///< Radius at which it saturates; > 0. Not given: half of the bounding box's diagonal.
  double min_angle_deg =
      5.0;  ///< Points that rise less than this above the tangent plane do not stop the sphere; [0.1, 45].
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
