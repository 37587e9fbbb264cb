/// \file
/// How hard a place is to reach: mean curvature of the surface at a physical scale.
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
/// A range that is at least 0.001 / scale wide, so that a plane or a sphere is even and not noise.
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

}  // namespace patinate
