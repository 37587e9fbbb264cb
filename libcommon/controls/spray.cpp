#include "patinate/controls/spray.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/ray_scene.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr double kDefaultDistance = 1.5;    ///< In diagonals of the bounding box.
constexpr double kConeEnd = 4.5;            ///< In spreads: what is farther off gets no paint (4e-5 of the middle).
constexpr double kSurfaceClearance = 1e-3;  ///< How far off the surface rays start, in diagonals.

void check_path(const std::vector<SprayStop>& path) {
  if (path.empty()) throw InvalidInput("spray: the path has no stops");
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::string stop = "spray: stop " + std::to_string(i + 1);
    const SprayStop& s = path[i];
    if (!s.position_mm.allFinite() || !s.aim_mm.allFinite()) throw InvalidInput(stop + " is not finite");
    if (!(s.dwell >= 0.0 && std::isfinite(s.dwell))) throw InvalidInput(stop + " has a dwell that is not >= 0");
    if (s.spread_deg && !(*s.spread_deg > 0.0 && *s.spread_deg <= 90.0))
      throw InvalidInput(stop + " has a spread outside (0, 90]");
    if (!((s.aim_mm - s.position_mm).norm() > 0.0)) throw InvalidInput(stop + " aims at its own position");
  }
}

constexpr double kStrokeStep = 0.1;  ///< Between stops of a stroke, in distances to the aim.
constexpr double kFarAway = 20.0;    ///< In diagonals.
constexpr double kMaxOfAWay = 500.0;

/// Says when the nozzle is so far away that a unit must be wrong.
void note_far(ControlMap& out, const std::vector<SprayStop>& path, const Box& box) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const SprayStop& stop : path)
    nearest = std::min(nearest, (stop.position_mm - box.center()).norm() / box.diagonal());
  if (nearest < kFarAway) return;
  out.notes.push_back("control `spray`: the nozzle stays " + short_number_text(rounded(nearest, 2)) +
                      " times the object's size away; are the path (mm) and the mesh in the same unit?");
}

/// Says which stops paint nothing.
void note_useless(ControlMap& out, const std::vector<std::uint8_t>& paints) {
  std::size_t num = 0, first = 0;
  for (std::size_t i = paints.size(); i-- > 0;) {
    if (paints[i] == 0) ++num, first = i;
  }
  if (num == 0) return;
  out.notes.push_back("control `spray`: " + std::to_string(num) + " of " + std::to_string(paints.size()) +
                      " stops paint nothing, the first is stop " + std::to_string(first + 1) +
                      "; do they aim at the mesh, in its unit?");
}

}  // namespace

void describe(OptionVisitor& v, SprayOptions& o) {
  v.visit({"spread", "standard deviation of the spray cone's Gaussian profile", "deg",
           Range{.low = 0, .high = 90, .is_low_open = true}},
          o.spread_deg);
  v.visit({"spray_shadows", "shadows of the object in its own spray"}, o.casts_shadows);
  v.visit({"full_percent", "percentile of the values, by area, that becomes 1", "%", between(51, 100)}, o.full_percent);
}

std::vector<SprayStop> default_spray_path(const Mesh& mesh) {
  const Box box = bounding_box(mesh);
  const Vec3 up_front(0.0, 0.6, 0.8);
  return {{.position_mm = box.center() + kDefaultDistance * box.diagonal() * up_front,
           .dwell = 1.0,
           .aim_mm = box.center()}};
}

std::vector<SprayStop> stroke_stops(const std::vector<SprayStroke>& strokes, const SprayOptions& options) {
  std::vector<SprayStop> stops;
  for (std::size_t n = 0; n < strokes.size(); ++n) {
    const SprayStroke& stroke = strokes[n];
    const std::string name = "spray: stroke " + std::to_string(n + 1);
    if (stroke.points.empty()) throw InvalidInput(name + " has no points");
    if (!(stroke.flow >= 0.0 && std::isfinite(stroke.flow))) throw InvalidInput(name + " has a flow that is not >= 0");
    check_path(stroke.points);
    if (stroke.points.size() == 1) {
      stops.push_back(stroke.points[0]);
      stops.back().dwell *= stroke.flow;
    }
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      const SprayStop &a = stroke.points[i], &b = stroke.points[i + 1];
      const double near = std::min((a.aim_mm - a.position_mm).norm(), (b.aim_mm - b.position_mm).norm());
      const double way = std::max((b.position_mm - a.position_mm).norm(), (b.aim_mm - a.aim_mm).norm());
      const int num = static_cast<int>(std::clamp(std::ceil(way / (kStrokeStep * near)), 1.0, kMaxOfAWay));
      const double spread_a = a.spread_deg.value_or(options.spread_deg),
                   spread_b = b.spread_deg.value_or(options.spread_deg);
      for (int k = 0; k < num; ++k) {
        const double f = (k + 0.5) / num;
        stops.push_back({.position_mm = (1.0 - f) * a.position_mm + f * b.position_mm,
                         .dwell = stroke.flow * a.dwell / num,
                         .aim_mm = (1.0 - f) * a.aim_mm + f * b.aim_mm,
                         .spread_deg = (1.0 - f) * spread_a + f * spread_b});
      }
    }
  }
  return stops;
}

ControlMap spray_map(const TexelMap& map, const std::vector<SprayStop>& path, const SprayOptions& options,
                     const RunControl& control) {
  check_ranges(options);
  check_path(path);
  std::optional<RayScene> scene;
  if (options.casts_shadows) scene.emplace(map.mesh());
  const double clearance = kSurfaceClearance * bounding_box(map.mesh()).diagonal();
  // Lengths in diagonals, so that 1 / d^2 stays in the range of float whatever the unit.
  const double unit = clearance / kSurfaceClearance;
  ImageF thickness(map.width(), map.height());
  std::vector<std::uint8_t> paints(path.size(), 0);
  parallel_for(map.num_texels(), 4096, control.part(0.0, 0.95), [&](TexelId begin, TexelId end) {
    for (TexelId t = begin; t < end; ++t) {
      if (!map.is_covered(t)) continue;
      const Vec3 normal = map.normal(t), position = map.position_mm(t);
      double sum = 0.0;
      for (std::size_t i = 0; i < path.size(); ++i) {
        const SprayStop& stop = path[i];
        const double spread = stop.spread_deg.value_or(options.spread_deg) * std::numbers::pi / 180.0;
        const Vec3 to_nozzle = stop.position_mm - position;
        const double distance = to_nozzle.norm();
        const double cosine = normal.dot(to_nozzle) / distance;
        if (!(cosine > 0.0)) continue;
        const Vec3 aim = (stop.aim_mm - stop.position_mm).normalized();
        const double angle = std::acos(std::clamp(-aim.dot(to_nozzle) / distance, -1.0, 1.0));
        if (!(angle < kConeEnd * spread)) continue;
        const double paint = stop.dwell * std::exp(-0.5 * (angle / spread) * (angle / spread)) * cosine *
                             (unit / distance) * (unit / distance);
        if (scene && paint > 0.0 && scene->is_blocked(position + clearance * normal, stop.position_mm, clearance))
          continue;
        // Threads only ever write the same 1.
        if (paint > 0.0) std::atomic_ref(paints[i]).store(1, std::memory_order_relaxed);
        sum += paint;
      }
      thickness.values()[t] = static_cast<float>(std::min(sum, 1e30));
    }
  });
  double high = area_percentiles(thickness, map, 0.0, options.full_percent).high;
  if (!(high > 0.0)) high = area_percentiles(thickness, map, 0.0, 100.0).high;
  if (!(high > 0.0)) {
    throw InvalidInput(
        "spray: no paint arrives at the surface; are the path and the mesh in the same unit, and does it aim at the "
        "mesh?");
  }
  ControlMap out = normalized_control(thickness, map, {0.0, high}, "relative");
  note_useless(out, paints);
  note_far(out, path, bounding_box(map.mesh()));
  control.report(1.0);
  return out;
}

}  // namespace patinate
