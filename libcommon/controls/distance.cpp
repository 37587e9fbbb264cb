#include "patinate/controls/distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/controls/light_set.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/geodesic.h"
#include "libcommon/geometry/nearest_points.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::array<std::string_view, 2> kMetricNames{"geodesic", "euclidean"};
constexpr double kStepShare = 0.0025;  ///< Between points on curves, in diagonals.
using Sources = std::vector<GeodesicSource>;

/// How sharply the edge (k, k + 1) of a triangle turns to its neighbor's plane: > 0 stands out, < 0 is sunk in.
double turn(const Mesh& mesh, int triangle, int neighbor) {
  const Vec3 a = area_vector(mesh, triangle).normalized(), b = area_vector(mesh, neighbor).normalized();
  const auto center = [&](int t) {
    Vec3 sum = Vec3::Zero();
    for (const int corner : mesh.triangles[t]) sum += mesh.positions[corner];
    return Vec3(sum / 3.0);
  };
  const double angle = std::acos(std::clamp(a.dot(b), -1.0, 1.0));
  return (center(neighbor) - center(triangle)).dot(a - b) <= 0.0 ? angle : -angle;
}

Sources edge_sources(const Mesh& mesh, DistanceSource::Edges edges, double crease_deg) {
  const double crease = crease_deg * std::numbers::pi / 180.0;
  const auto neighbors = triangle_neighbors(mesh);
  Sources sources;
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int other = neighbors[t][k];
      bool is_source = other < 0 && edges == DistanceSource::Edges::Boundary;
      if (other >= 0 && edges != DistanceSource::Edges::Boundary) {
        const double angle = turn(mesh, t, other);
        is_source = (angle > crease && edges != DistanceSource::Edges::Valleys) ||
                    (angle < -crease && edges != DistanceSource::Edges::Ridges);
      }
      if (!is_source) continue;
      const Triangle& corners = mesh.triangles[t];
      const Vec3 &a = mesh.positions[corners[k]], &b = mesh.positions[corners[(k + 1) % 3]];
      for (const double f : {0.0, 0.25, 0.5, 0.75, 1.0}) sources.push_back({t, (1.0 - f) * a + f * b});
    }
  }
  if (sources.empty()) {
    throw InvalidInput(edges == DistanceSource::Edges::Boundary
                           ? "distance: the surface is closed and has no boundary; measure from `creases` or a file"
                           : "distance: no edge of the mesh is a crease of that kind; lower --crease-angle (" +
                                 short_number_text(crease_deg) + " deg)");
  }
  return sources;
}

/// The point of a triangle that is nearest to `p`, to good accuracy for points near it: outside weights are cut off.
Vec3 onto_triangle(const Mesh& mesh, int triangle, const Vec3& p) {
  const Triangle& c = mesh.triangles[triangle];
  const auto corner = [&](std::size_t k) { return mesh.positions[c[k]]; };
  const Vec3 ab = corner(1) - corner(0), ac = corner(2) - corner(0), normal = ab.cross(ac);
  const double squared = normal.squaredNorm();
  if (!(squared > 0.0)) return corner(0);
  Vec3 w;
  w[1] = std::max(0.0, (p - corner(0)).cross(ac).dot(normal) / squared);
  w[2] = std::max(0.0, ab.cross(p - corner(0)).dot(normal) / squared);
  w[0] = std::max(0.0, 1.0 - (ab.cross(p - corner(0)).dot(normal) + (p - corner(0)).cross(ac).dot(normal)) / squared);
  w /= w.sum();
  return w[0] * corner(0) + w[1] * corner(1) + w[2] * corner(2);
}

std::vector<Vec3> sampled(const std::vector<std::vector<Vec3>>& curves, double step) {
  std::vector<Vec3> points;
  for (const auto& curve : curves) {
    for (std::size_t i = 0; i < curve.size(); ++i) {
      if (!curve[i].allFinite()) throw InvalidInput("distance: a point of the curve is not finite");
      points.push_back(curve[i]);
      if (i + 1 == curve.size()) break;
      const double length = (curve[i + 1] - curve[i]).norm();
      const int num = static_cast<int>(std::min(length / step, 100'000.0));
      for (int k = 1; k < num; ++k)
        points.push_back(curve[i] + (static_cast<double>(k) / num) * (curve[i + 1] - curve[i]));
    }
  }
  return points;
}

Sources curve_sources(const Mesh& mesh, const std::vector<std::vector<Vec3>>& curves) {
  const double diagonal = bounding_box(mesh).diagonal();
  const NearestPoints vertices(mesh.positions);
  std::vector<std::vector<int>> around(mesh.positions.size());
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    for (const int corner : mesh.triangles[t]) around[corner].push_back(t);
  }
  Sources sources;
  for (const Vec3& p : sampled(curves, kStepShare * diagonal)) {
    const auto found = vertices.nearest(p);
    if (found.distance > diagonal) {
      throw InvalidInput("distance: a point lies " + short_number_text(found.distance) +
                         " mm off the surface, more than the object is large; are both in the same unit?");
    }
    GeodesicSource best;
    double least = 1e300;
    for (const int t : around[found.index]) {
      const Vec3 on = onto_triangle(mesh, t, p);
      if (!((on - p).norm() < least)) continue;
      least = (on - p).norm();
      best = {t, on};
    }
    if (best.triangle >= 0) sources.push_back(best);
  }
  return sources;
}

Sources mask_sources(const SmoothSurface& surface, const ImageF& mask) {
  if (mask.width() != surface.map().width() || mask.height() != surface.map().height()) {
    throw InvalidInput("distance: the mask differs from the atlas in size");
  }
  Sources sources;
  for (TexelId t = 0; t < surface.map().num_texels(); ++t) {
    if (!(mask.values()[t] >= 0.5F)) continue;
    if (const auto p = surface.point(t)) sources.push_back({p->triangle, surface.position_mm(t)});
  }
  if (sources.empty()) throw InvalidInput("distance: the mask is below 0.5 on the whole surface");
  return sources;
}

}  // namespace

void describe(OptionVisitor& v, DistanceOptions& o) {
  v.visit_choice({"distance_metric", "distance along the surface or straight"}, o.metric, kMetricNames);
  v.visit({"distance_range", "distance that 1 stands for; not given: the greatest", "mm", above(0)}, o.range_mm);
  v.visit({"crease_angle", "smallest angle between the normals of both sides that makes an edge a crease", "deg",
           between(1, 179)},
          o.crease_deg);
}

ControlMap distance_map(const TexelMap& map, const DistanceSource& source, const DistanceOptions& options,
                        const RunControl& control) {
  check_ranges(options);
  const SmoothSurface surface = surface_for_rays(map, control.part(0.0, 0.2));
  const Sources sources = source.edges != DistanceSource::Edges::None
                              ? edge_sources(surface.mesh(), source.edges, options.crease_deg)
                          : !source.curves.empty() ? curve_sources(surface.mesh(), source.curves)
                                                   : mask_sources(surface, source.mask);
  ImageF values(map.width(), map.height(), 1, -1.0F);
  const auto fill = [&](auto&& distance_at) {
    parallel_for(map.num_texels(), 1024, control.part(0.7, 0.99), [&](TexelId begin, TexelId end) {
      for (TexelId t = begin; t < end; ++t) {
        const auto p = map.is_covered(t) ? surface.point(t) : std::nullopt;
        if (!p) continue;
        const double distance = distance_at(p->triangle, surface.position_mm(t));
        if (std::isfinite(distance)) values.values()[t] = static_cast<float>(distance);
      }
    });
  };
  if (options.metric == DistanceMetric::Geodesic) {
    const GeodesicDistance geodesic(surface.mesh(), sources, control.part(0.2, 0.7));
    fill([&](int triangle, const Vec3& p) { return geodesic.at(triangle, p); });
  } else {
    std::vector<Vec3> points;
    for (const GeodesicSource& s : sources) points.push_back(s.position);
    const NearestPoints nearest(std::move(points));
    fill([&](int, const Vec3& p) { return nearest.nearest(p).distance; });
  }
  float greatest = 0.0F;
  std::int64_t num_unreached = 0;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    const auto i = static_cast<std::size_t>(t);
    if (!source.mask.empty() && source.mask.values()[i] >= 0.5F) values.values()[i] = 0.0F;
    greatest = std::max(greatest, values.values()[i]);
    num_unreached += map.is_covered(t) && surface.point(t) && values.values()[i] < 0.0F ? 1 : 0;
  }
  const double high = options.range_mm.value_or(greatest > 0.0F ? static_cast<double>(greatest) : 1.0);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    float& value = values.values()[t];
    if (value < 0.0F) value = static_cast<float>(high);
  }
  surface.fill_gaps(values);
  ControlMap out = normalized_control(values, map, {0.0, high}, "mm");
  if (num_unreached > 0) {
    const double percent = 100.0 * static_cast<double>(num_unreached) / static_cast<double>(map.num_covered());
    out.notes.push_back("control `distance`: no way over the surface leads to " +
                        short_number_text(rounded(percent, 2)) +
                        " % of the texels, which are 1; --distance-metric euclidean reaches them");
  }
  control.report(1.0);
  return out;
}

}  // namespace patinate
