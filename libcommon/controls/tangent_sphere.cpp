#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "libcommon/controls/smooth_surface.h"
#include "libcommon/core/parallel.h"
#include "libcommon/geometry/nearest_points.h"
#include "patinate/controls/accessibility.h"

namespace patinate {

namespace {

constexpr double kPointSpacingShare = 0.004;  ///< Longest distance of the points that stop spheres, in diagonals.
constexpr int kMaxSphereTriangles = 1'000'000;
constexpr double kOwnShare = 0.006;  ///< Points nearer than this, in diagonals, are on the same surface.
constexpr int kMaxSteps = 60;
constexpr double kSmooth = 0.94;  ///< Cosine of 20 degrees.
constexpr double kConverged =
    1e-3;  ///< Relative; the points are coarser. In a hollow sphere all points are equally near.

/// Normals of the surface's shape, not of its shading: the two differ by some degrees on a low-polygon model, which
/// would make spheres out of nothing.
Vec3 shape_normal(const SmoothSurface& surface, const std::vector<Vec3>& normals, TexelId t) {
  const std::optional<SurfacePoint> p = surface.point(t);
  if (!p) return surface.normal(t);
  const Triangle& corners = surface.mesh().triangles[p->triangle];
  const auto at = [&](std::size_t k) { return normals[corners[k]]; };
  const Vec3 flat = area_vector(surface.mesh(), p->triangle).normalized();
  const Vec3 n = (1.0 - p->b1 - p->b2) * at(0) + p->b1 * at(1) + p->b2 * at(2);
  // At a hard edge the corners' normals lie between the sides'.
  return n.norm() > 0.0 && n.normalized().dot(flat) > kSmooth ? Vec3(n.normalized()) : flat;
}

/// A sphere that touches the surface from outside.
struct TangentSphere {
  double radius = 0.0;
  int stopped_by = -1;  ///< Index of the point that it also passes through, -1 = none.
};

/// Shrinks the sphere until it holds no point that counts: each point that it holds shrinks it to pass through itself.
/// @param hint  A point that is likely to stop it, or -1. Every point that counts bounds the radius, so a hint saves
///              steps; the result is within `kConverged` of the same radius.
TangentSphere tangent_sphere(const NearestPoints& points, const Vec3& p, const Vec3& normal, double largest, double own,
                             double min_sine, int hint) {
  const auto counts = [&](const Vec3& q) {
    const Vec3 d = q - p;
    const double distance = d.norm();
    return distance > own && d.dot(normal) > min_sine * distance;
  };
  const auto radius_through = [&](int index) {
    const Vec3 d = points.point(index) - p;
    return d.squaredNorm() / (2.0 * d.dot(normal));
  };
  TangentSphere sphere{.radius = largest};
  if (hint >= 0 && counts(points.point(hint)) && radius_through(hint) < largest)
    sphere = {.radius = radius_through(hint), .stopped_by = hint};
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto found = points.nearest_of(p + sphere.radius * normal, sphere.radius * (1.0 - kConverged), counts);
    if (found.index < 0) break;
    sphere = {.radius = radius_through(found.index), .stopped_by = found.index};
  }
  return sphere;
}

}  // namespace

void describe(OptionVisitor& v, TangentSphereOptions& o) {
  v.visit(
      {"largest_sphere", "radius at which `tangent_sphere` saturates; not given: half of the bounding box's diagonal",
       "mm", above(0)},
      o.largest_mm);
  v.visit({"sphere_angle",
           "points that rise less than this above the tangent plane do not stop the sphere of `tangent_sphere`", "deg",
           between(0.1, 45)},
          o.min_angle_deg);
  v.visit({"sphere_percent", "percentile of the values of `tangent_sphere`, by area, that becomes 1", "%",
           between(51, 100)},
          o.full_percent);
}

ControlMap tangent_sphere_map(const TexelMap& map, const TangentSphereOptions& options, const RunControl& control) {
  check_ranges(options);
  const double diagonal = bounding_box(map.mesh()).diagonal();
  const double largest = options.largest_mm.value_or(0.5 * diagonal);
  const double min_sine = std::sin(options.min_angle_deg * std::numbers::pi / 180.0);
  const SmoothSurface surface(map, kPointSpacingShare * diagonal, kMaxSphereTriangles, control.part(0.0, 0.2));
  const std::vector<Vec3> normals = vertex_normals(surface.mesh());
  const double own = kOwnShare * diagonal;
  const NearestPoints points(surface.mesh().positions);
  ImageF values(map.width(), map.height());
  parallel_for(map.num_texels(), 256, control.part(0.2, 0.99), [&](TexelId begin, TexelId end) {
    TangentSphere sphere;
    for (TexelId t = begin; t < end; ++t) {
      if (!map.is_covered(t)) continue;
      sphere = tangent_sphere(points, surface.position_mm(t), shape_normal(surface, normals, t), largest, own, min_sine,
                              sphere.stopped_by);
      values.values()[t] = static_cast<float>(std::min(1.0 / sphere.radius, 1e30));
    }
  });
  const double low = 1.0 / largest;
  double high = area_percentiles(values, map, 0.0, options.full_percent).high;
  if (!(high > 1.001 * low)) high = 2.0 * low;  // everything saturates
  ControlMap out = normalized_control(values, map, {low, high}, "1/mm");
  control.report(1.0);
  return out;
}

}  // namespace patinate
