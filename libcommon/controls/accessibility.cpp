#include "libcommon/controls/accessibility.h"

#include <algorithm>

#include "libcommon/atlas/dilate.h"
#include "libcommon/geometry/curvature.h"

namespace patinate {

namespace {

constexpr double kDefaultScaleShare = 0.02;  ///< Of the bounding box's diagonal.
constexpr int kMaxTriangles = 1'000'000;
constexpr double kMinRangeTimesScale = 1e-3;

/// Values at positions of `fine`, interpolated to the texels that `map` covers.
ImageF rasterize(const std::vector<double>& values, Mesh fine, const TexelMap& map, const RunControl& control) {
  const TexelMap fine_map(std::move(fine), map.width(), map.height(), control);
  ImageF image(map.width(), map.height());
  for (TexelId t = 0; t < fine_map.num_texels(); ++t) {
    if (!fine_map.is_covered(t)) continue;
    const SurfacePoint p = fine_map.point(t);
    const Triangle& corners = fine_map.mesh().triangles[static_cast<std::size_t>(p.triangle)];
    const auto at = [&](std::size_t k) { return values[static_cast<std::size_t>(corners[k])]; };
    image.values()[static_cast<std::size_t>(t)] =
        static_cast<float>((1.0 - p.b1 - p.b2) * at(0) + p.b1 * at(1) + p.b2 * at(2));
  }
  // Rounding may leave a texel on an edge to no fine triangle.
  dilate(image, fine_map.coverage(), -1);
  return image;
}

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
  Mesh fine =
      refine_edges(map.mesh(), scale / 2.0, std::max(kMaxTriangles, map.mesh().num_triangles()), RefineShape::Curved);
  control.throw_if_stopped();
  control.report(0.2);
  const std::vector<double> curvature = mean_curvature(fine, scale, control.part(0.2, 0.8));
  const ImageF values = rasterize(curvature, std::move(fine), map, control.part(0.8, 0.95));
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
