/// \file
/// Accessibility of a scan as a height function, beside the two other definitions, and how far the three agree.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "libcommon/geometry/height_field.h"
#include "patinate/controls/accessibility.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Settings of height_accessibility().
struct HeightAccessibilityOptions {
  std::optional<double>
      scale_mm;  ///< Standard deviation of height_curvature()'s Gaussian; > 0. Not given: 2 % of the box's diagonal.
  int resolution = 256;        ///< Heights along the longer side of what is seen; [32, 2048].
  double low_percent = 1.0;    ///< This share of the surface is at most what 0 stands for; [0, 49].
  double high_percent = 99.0;  ///< This share is at most what 1 stands for; [51, 100].
  RayShareOptions ray_share = {};
  TangentSphereOptions tangent_sphere = {};
};
void describe(OptionVisitor& v, HeightAccessibilityOptions& o);

/// One definition of "hard to reach".
struct AccessibilityDefinition {
  std::string name;  ///< "accessibility", "ray_share", "tangent_sphere".
  std::string unit;  ///< "1/mm", "share", "1/mm".
  ImageF values;     ///< On the grid; physical; 0 outside `seen`.
  double low = 0.0;  ///< Values that 0 and 1 of a control stand for.
  double high = 1.0;
};

struct HeightAccessibility {
  HeightField field;  ///< `seen` where all three are known.
  double scale_mm = 0.0;
  std::array<AccessibilityDefinition, 3> definitions;
  std::array<std::array<double, 3>, 3> correlation{};  ///< Correlation of ranks, over the grid's pixels that are seen.
};

/// The mean curvature of the height function that `viewer` sees (height_curvature()), and ray_share_map() and
/// tangent_sphere_map() of that same height function as a surface.
/// @param mesh_mm  In mm. @param viewer  Unit, from the surface to the viewer.
/// @throws InvalidInput if an option is out of range or nothing is seen. Same bits for any number of threads.
/// Cost: resolution^2 x rays; about 10 s at the defaults on two cores.
[[nodiscard]] HeightAccessibility height_accessibility(const Mesh& mesh_mm, const Vec3& viewer,
                                                       const HeightAccessibilityOptions& options = {},
                                                       const RunControl& control = {});

}  // namespace patinate
