#include "libcommon/controls/accessibility.h"

#include "libcommon/controls/smooth_surface.h"
#include "libcommon/geometry/curvature.h"

namespace patinate {

namespace {

constexpr double kDefaultScaleShare = 0.02;  ///< Of the bounding box's diagonal.
constexpr int kMaxTriangles = 1'000'000;
constexpr double kMinRangeTimesScale = 1e-3;

}  // namespace

void describe(OptionVisitor& v, AccessibilityOptions& o) {
  v.visit({"scale", "size of the features that accessibility sees; not given: 2 % of the bounding box's diagonal", "mm",
           above(0)},
          o.scale_mm);
  v.visit({"low_percent", "share of the area that is at most what 0 stands for", "%", between(0, 49)}, o.low_percent);
  v.visit({"high_percent", "share of the area that is at most what 1 stands for", "%", between(51, 100)},
          o.high_percent);
}

double default_accessibility_scale_mm(const Mesh& mesh) { return kDefaultScaleShare * bounding_box(mesh).diagonal(); }

ControlMap accessibility_map(const TexelMap& map, const AccessibilityOptions& options, const RunControl& control) {
  check_ranges(options);
  const double scale = options.scale_mm.value_or(default_accessibility_scale_mm(map.mesh()));
  const SmoothSurface surface(map, scale / 2.0, kMaxTriangles, control.part(0.0, 0.35));
  const std::vector<double> curvature = mean_curvature(surface.mesh(), scale, control.part(0.35, 0.95));
  const ImageF values = surface.to_texels(curvature);
  ValueRange range = area_percentiles(values, map, options.low_percent, options.high_percent);
  const double missing = kMinRangeTimesScale / scale - (range.high - range.low);
  if (missing > 0.0) {
    range.low -= missing / 2.0;
    range.high += missing / 2.0;
  }
  ControlMap out = normalized_control(values, map, range, "1/mm");
  control.report(1.0);
  return out;
}

}  // namespace patinate
