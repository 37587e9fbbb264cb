#include "libcommon/controls/height_accessibility.h"

#include <algorithm>
#include <vector>

#include "libcommon/image/filters.h"
#include "libcommon/metrics/correlation.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/controls/accessibility.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// The height function as a mesh whose texels are the grid's pixels.
Mesh surface_of(const HeightField& field) {
  const int width = field.seen.width(), height = field.seen.height();
  Mesh mesh;
  Image<int> index(width, height, 1, -1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (field.seen.at(x, y) == 0) continue;
      index.at(x, y) = static_cast<int>(mesh.positions.size());
      mesh.positions.push_back(field.origin + field.spacing_mm * (x * field.right + y * field.down) +
                               field.height_mm.at(x, y) * field.viewer);
      mesh.uvs.emplace_back((x + 0.5) / width, 1.0 - (y + 0.5) / height);
    }
  }
  const auto add = [&](int a, int b, int c) {
    if (a >= 0 && b >= 0 && c >= 0) mesh.triangles.push_back({a, b, c});
  };
  for (int y = 0; y + 1 < height; ++y) {
    for (int x = 0; x + 1 < width; ++x) {
      add(index.at(x, y), index.at(x, y + 1), index.at(x + 1, y));
      add(index.at(x + 1, y), index.at(x, y + 1), index.at(x + 1, y + 1));
    }
  }
  mesh.uv_triangles = mesh.triangles;
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  mesh.surfaces = {{}};
  if (mesh.triangles.empty())
    throw InvalidInput("accessibility: what is seen is too small for a surface; raise the resolution");
  return with_normals(std::move(mesh));
}

AccessibilityDefinition physical(const std::string& name, const ControlMap& map) {
  AccessibilityDefinition out{name, map.unit, map.values, map.low, map.high};
  for (float& v : out.values.values()) v = static_cast<float>(map.low + (map.high - map.low) * static_cast<double>(v));
  return out;
}

}  // namespace

void describe(OptionVisitor& v, HeightAccessibilityOptions& o) {
  v.visit({"scale",
           "width of the Gaussian: not larger than half of the smallest feature to keep; not given: 2 % of the "
           "bounding box's diagonal",
           "mm", above(0)},
          o.scale_mm);
  v.visit({"resolution", "heights along the longer side of what is seen", "", between(32, 2048)}, o.resolution);
  v.visit({"low_percent", "share of the surface that is at most what 0 stands for", "%", between(0, 49)},
          o.low_percent);
  v.visit({"high_percent", "share of the surface that is at most what 1 stands for", "%", between(51, 100)},
          o.high_percent);
  describe(v, o.ray_share);
  describe(v, o.tangent_sphere);
}

HeightAccessibility height_accessibility(const Mesh& mesh, const Vec3& viewer,
                                         const HeightAccessibilityOptions& options, const RunControl& control) {
  check_ranges(options);
  HeightAccessibility out;
  out.scale_mm = options.scale_mm.value_or(default_accessibility_scale_mm(mesh));
  const RayScene scene(mesh);
  // The extent that the viewer sees: a coarse look first.
  const double diagonal = bounding_box(mesh).diagonal();
  const HeightField coarse = height_field(mesh, scene, viewer, diagonal / 64.0, control.part(0.0, 0.02));
  const double extent = coarse.spacing_mm * std::max(coarse.seen.width(), coarse.seen.height());
  out.field = height_field(mesh, scene, viewer, extent / options.resolution, control.part(0.02, 0.05));
  ImageF curvature = height_curvature(out.field, out.scale_mm, control.part(0.05, 0.15));
  const TexelMap map(surface_of(out.field), out.field.seen.width(), out.field.seen.height(), control.part(0.15, 0.2));
  out.definitions[1] = physical("ray_share", ray_share_map(map, options.ray_share, control.part(0.2, 0.7)));
  out.definitions[2] =
      physical("tangent_sphere", tangent_sphere_map(map, options.tangent_sphere, control.part(0.7, 0.95)));
  std::array<std::vector<double>, 3> lists;
  for (std::int64_t i = 0; i < map.num_texels(); ++i) {
    if (!map.is_covered(i)) {
      out.field.seen.data()[i] = 0;
      curvature.data()[i] = 0.0f;
    }
    if (out.field.seen.data()[i] == 0) {
      for (std::size_t k = 1; k < 3; ++k) out.definitions[k].values.data()[i] = 0.0f;
      continue;
    }
    lists[0].push_back(static_cast<double>(curvature.data()[i]));
    for (std::size_t k = 1; k < 3; ++k) lists[k].push_back(static_cast<double>(out.definitions[k].values.data()[i]));
  }
  const Percentiles ends =
      percentiles(curvature, out.field.seen, options.low_percent / 100.0, options.high_percent / 100.0);
  const ValueRange range =
      widened_accessibility_range({static_cast<double>(ends.low), static_cast<double>(ends.high)}, out.scale_mm);
  out.definitions[0] = {"accessibility", "1/mm", std::move(curvature), range.low, range.high};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) out.correlation[a][b] = a == b ? 1.0 : rank_correlation(lists[a], lists[b]);
  }
  control.report(1.0);
  return out;
}

}  // namespace patinate
