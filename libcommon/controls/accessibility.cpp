#include "patinate/controls/accessibility.h"

#include <algorithm>
#include <cmath>

#include "libcommon/controls/smooth_surface.h"
#include "libcommon/geometry/curvature.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr double kDefaultScaleShare = 0.02;  ///< Share of the bounding box's diagonal.
constexpr int kMaxCurvatureTriangles = 1'000'000;
constexpr double kMinRangeTimesScale = 1e-3;

}  // namespace

void describe(OptionVisitor& v, AccessibilityOptions& o) {
  v.visit({"scale", "size of the features that accessibility sees; not given: 2 % of the bounding box's diagonal", "mm",
           above(0)},
          o.scale_mm);
  v.visit({"low_percent", "percentile of the values, by area, that becomes 0", "%", between(0, 49)}, o.low_percent);
  v.visit({"high_percent", "percentile of the values, by area, that becomes 1", "%", between(51, 100)}, o.high_percent);
}

double default_accessibility_scale_mm(const Mesh& mesh) { return kDefaultScaleShare * bounding_box(mesh).diagonal(); }

AccessibleSurface accessible_surface(const Mesh& mesh, std::optional<double> scale_mm, const RunControl& control) {
  AccessibleSurface surface;
  surface.scale_mm = scale_mm.value_or(default_accessibility_scale_mm(mesh));
  if (!(surface.scale_mm > 0.0 && std::isfinite(surface.scale_mm)))
    throw InvalidInput("accessibility: the mesh has no size, or the scale is not > 0");
  surface.mesh = refine_edges(mesh, surface.scale_mm / 2.0, std::max(kMaxCurvatureTriangles, mesh.num_triangles()),
                              RefineShape::Curved);
  control.throw_if_stopped();
  surface.curvature_per_mm = mean_curvature(surface.mesh, surface.scale_mm, control.part(0.3, 1.0));
  return surface;
}

ValueRange widened_accessibility_range(ValueRange range, double scale_mm) {
  const double missing = kMinRangeTimesScale / scale_mm - (range.high - range.low);
  if (missing > 0.0) {
    range.low -= missing / 2.0;
    range.high += missing / 2.0;
  }
  return range;
}

ControlMap accessibility_map(const TexelMap& map, const AccessibilityOptions& options, const RunControl& control) {
  check_ranges(options);
  const double scale = options.scale_mm.value_or(default_accessibility_scale_mm(map.mesh()));
  const SmoothSurface surface(map, scale / 2.0, kMaxCurvatureTriangles, control.part(0.0, 0.35));
  const std::vector<double> curvature = mean_curvature(surface.mesh(), scale, control.part(0.35, 0.95));
  control.throw_if_stopped();
  const ImageF values = surface.to_texels(curvature);
  control.throw_if_stopped();
  const ValueRange range =
      widened_accessibility_range(area_percentiles(values, map, options.low_percent, options.high_percent), scale);
  control.throw_if_stopped();
  ControlMap out = normalized_control(values, map, range, "1/mm");
  control.report(1.0);
  return out;
}

}  // namespace patinate
