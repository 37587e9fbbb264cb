#include "libcommon/controls/light_set.h"
#include "patinate/controls/accessibility.h"

namespace patinate {

namespace {

constexpr double kReachShare = 0.1;  ///< Share of the bounding box's diagonal.

}  // namespace

void describe(OptionVisitor& v, RayShareOptions& o) {
  v.visit({"share_rays", "rays from each point for `ray_share`", "", between(16, 4096)}, o.num_rays);
  v.visit(
      {"reach", "length of the rays of `ray_share`; not given: 10 % of the bounding box's diagonal", "mm", above(0)},
      o.reach_mm);
}

ControlMap ray_share_map(const TexelMap& map, const RayShareOptions& options, const RunControl& control) {
  check_ranges(options);
  const double reach = options.reach_mm.value_or(kReachShare * bounding_box(map.mesh()).diagonal());
  const SmoothSurface surface = surface_for_rays(map, control.part(0.0, 0.1));
  const ImageF values =
      shadowed_light(surface, even_sphere(2 * options.num_rays), reach, true, control.part(0.1, 0.99));
  ControlMap out = normalized_control(values, map, {0.0, 1.0}, "share");
  control.report(1.0);
  return out;
}

}  // namespace patinate
