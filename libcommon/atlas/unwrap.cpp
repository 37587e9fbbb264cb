#include "patinate/atlas/unwrap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <vector>

#include "libcommon/atlas/unwrap_charts.h"
#include "libcommon/atlas/unwrap_flatten.h"
#include "libcommon/atlas/unwrap_pack.h"
#include "libcommon/atlas/unwrap_surface.h"
#include "libcommon/core/parallel.h"
#include "patinate/core/run_control.h"

namespace patinate {

namespace {

constexpr double kConeShare = 0.95;
constexpr double kMinShare = 0.15;  ///< Share of the smaller chart's border that must be shared: no chains of charts.
constexpr int kMaxCandidates = 3;
constexpr std::int64_t kMaxWork = 6;  ///< Triangles flattened in attempts, over triangles of the mesh.

class Merger {
 public:
  Merger(const UnwrapSurface& surface, double max_normal_angle_deg, double max_stretch, std::vector<FlatChart>& charts)
      : surface_(surface),
        charts_(charts),
        chart_of_(surface.triangles.size(), -1),
        max_stretch_(max_stretch),
        least_cos_(std::cos(max_normal_angle_deg * std::numbers::pi / 180.0)) {
    for (std::size_t c = 0; c < charts.size(); ++c) take(c);
  }

  void run(const RunControl& control) {
    std::int64_t work_left = kMaxWork * surface_.num_triangles();
    for (bool has_merged = true; has_merged && work_left > 0;) {
      has_merged = false;
      std::vector<std::size_t> order(charts_.size());
      std::iota(order.begin(), order.end(), std::size_t{0});
      std::erase_if(order, [&](std::size_t c) { return charts_[c].triangles.empty(); });
      std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return area_[a] < area_[b]; });
      for (std::size_t c : order) {
        control.throw_if_stopped();
        if (!charts_[c].triangles.empty()) has_merged |= merge_one(c, work_left);
      }
    }
    std::erase_if(charts_, [](const FlatChart& chart) { return chart.triangles.empty(); });
  }

 private:
  void take(std::size_t c) {
    if (area_.size() <= c) area_.resize(c + 1);
    area_[c] = 0.0;
    for (int t : charts_[c].triangles) {
      chart_of_[t] = static_cast<int>(c);
      area_[c] += surface_.areas[t];
    }
  }

  /// (length of border shared, chart), longest first, of those that share enough; borders on creases count a fifth.
  [[nodiscard]] std::vector<std::pair<double, int>> candidates(std::size_t c) const {
    std::map<int, double> shared;
    double border = 0.0;
    for (int triangle : charts_[c].triangles) {
      const auto t = static_cast<std::size_t>(triangle);
      for (std::size_t k = 0; k < 3; ++k) {
        const int n = surface_.neighbors[t][k];
        const int other = n < 0 ? -1 : chart_of_[n];
        if (other == static_cast<int>(c)) continue;
        const Triangle& corners = surface_.triangles[t];
        const double length = (surface_.positions[corners[k]] - surface_.positions[corners[(k + 1) % 3]]).norm();
        border += length;
        if (other >= 0)
          shared[other] += length * (0.2 + 0.8 * std::clamp(surface_.normals[t].dot(surface_.normals[n]), 0.0, 1.0));
      }
    }
    std::vector<std::pair<double, int>> sorted;
    for (const auto& [other, length] : shared) {
      if (length >= kMinShare * border) sorted.emplace_back(length, other);
    }
    std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    if (sorted.size() > kMaxCandidates) sorted.resize(kMaxCandidates);
    return sorted;
  }

  [[nodiscard]] bool is_within_cone(const std::vector<int>& triangles) const {
    const Vec3 axis = chart_axis(surface_, triangles);
    double inside = 0.0, total = 0.0;
    for (int t : triangles) {
      const double area = surface_.areas[t];
      total += area;
      if (axis.dot(surface_.normals[t]) >= least_cos_) inside += area;
    }
    return inside >= kConeShare * total;
  }

  bool merge_one(std::size_t c, std::int64_t& work_left) {
    for (const auto& [length, other] : candidates(c)) {
      const auto o = static_cast<std::size_t>(other);
      std::vector<int> both(charts_[c].triangles.size() + charts_[o].triangles.size());
      if (static_cast<std::int64_t>(both.size()) > work_left) continue;
      std::merge(charts_[c].triangles.begin(), charts_[c].triangles.end(), charts_[o].triangles.begin(),
                 charts_[o].triangles.end(), both.begin());
      if (!is_within_cone(both)) continue;
      work_left -= static_cast<std::int64_t>(both.size());
      FlatChart merged = flatten_chart(surface_, std::move(both), max_stretch_);
      if (merged.status != FlatStatus::Good) continue;
      charts_[c] = FlatChart{};
      charts_[o] = std::move(merged);
      take(o);
      return true;
    }
    return false;
  }

  const UnwrapSurface& surface_;
  std::vector<FlatChart>& charts_;
  std::vector<int> chart_of_;
  std::vector<double> area_;
  double max_stretch_;
  double least_cos_;
};

/// Joins small charts first, each with the neighbor it shares most of its border with (creases count less), where
/// normals of the union keep to a cone of `max_normal_angle_deg` for 95 % of the area and it is flattened as Good.
/// @param charts  All Good; joined in place, order changed.
void merge_charts(const UnwrapSurface& surface, double max_normal_angle_deg, double max_stretch,
                  std::vector<FlatChart>& charts, const RunControl& control) {
  Merger(surface, max_normal_angle_deg, max_stretch, charts).run(control);
}

constexpr double kMergedCone = 1.5;  ///< Cone of joined charts, over that of charts while they grow.
constexpr double kWidestCone_deg = 100.0;
constexpr double kMergedStretch =
    0.6;  ///< Share of the stretch allowed: a seam less is worth less stretch than a chart less.

/// Lays all sets flat, cutting again those that are not Good. One triangle always is.
std::vector<FlatChart> flatten_all(const UnwrapSurface& surface, std::vector<std::vector<int>> sets, double max_stretch,
                                   const RunControl& control) {
  std::vector<FlatChart> good;
  ChartSplitter splitter(surface);
  for (int round = 1; !sets.empty(); ++round) {
    std::vector<FlatChart> charts(sets.size());
    RunControl quiet = control;
    quiet.on_progress = nullptr;
    parallel_for(static_cast<std::int64_t>(sets.size()), 1, quiet, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        charts[i] = flatten_chart(surface, std::move(sets[i]), max_stretch);
      }
    });
    sets.clear();
    for (FlatChart& chart : charts) {
      control.throw_if_stopped();
      if (chart.status == FlatStatus::Good) {
        good.push_back(std::move(chart));
      } else {
        for (std::vector<int>& part : splitter.split(chart.triangles)) sets.push_back(std::move(part));
      }
    }
    control.report(1.0 - 1.0 / (round + 1));
  }
  return good;
}

std::vector<std::vector<int>> connected_charts(const UnwrapSurface& surface, const std::vector<int>& triangle_chart) {
  std::vector<std::vector<int>> sets;
  for (const std::vector<int>& triangles : triangles_by_chart(triangle_chart)) {
    for (std::vector<int>& part : connected_parts(surface, triangles, triangle_chart)) sets.push_back(std::move(part));
  }
  return sets;
}

void sort_by_area(const UnwrapSurface& surface, std::vector<FlatChart>& charts) {
  std::vector<std::pair<double, std::size_t>> order(charts.size());
  for (std::size_t i = 0; i < charts.size(); ++i) {
    double area = 0.0;
    for (int t : charts[i].triangles) area += surface.areas[t];
    order[i] = {-area, i};
  }
  std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : charts[a.second].triangles[0] < charts[b.second].triangles[0];
  });
  std::vector<FlatChart> sorted;
  sorted.reserve(charts.size());
  for (const auto& [area, i] : order) sorted.push_back(std::move(charts[i]));
  charts = std::move(sorted);
}

/// UVs of the charts; triangles without area get the point of the atlas where one of their positions lies.
void set_uvs(const UnwrapSurface& surface, const std::vector<FlatChart>& charts, UnwrapResult& result) {
  Mesh& mesh = result.mesh;
  mesh.uvs.clear();
  mesh.uv_triangles.assign(mesh.triangles.size(), {0, 0, 0});
  result.triangle_chart.assign(mesh.triangles.size(), 0);
  std::vector<int> uv_at(mesh.positions.size(), -1);
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const int first = static_cast<int>(mesh.uvs.size());
    for (const Vec2& p : charts[c].points) mesh.uvs.push_back(p.cwiseMax(0.0).cwiseMin(1.0));
    for (std::size_t i = 0; i < charts[c].triangles.size(); ++i) {
      const auto t = static_cast<std::size_t>(charts[c].triangles[i]);
      result.triangle_chart[t] = static_cast<int>(c);
      for (std::size_t k = 0; k < 3; ++k) {
        mesh.uv_triangles[t][k] = first + charts[c].corners[i][k];
        uv_at[mesh.triangles[t][k]] = mesh.uv_triangles[t][k];
      }
    }
    result.num_planar_charts += charts[c].is_planar ? 1 : 0;
  }
  std::vector<int> chart_at(mesh.uvs.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int uv : mesh.uv_triangles[t]) chart_at[uv] = result.triangle_chart[t];
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!surface.is_point[t]) continue;
    const int uv = std::max({uv_at[mesh.triangles[t][0]], uv_at[mesh.triangles[t][1]], uv_at[mesh.triangles[t][2]], 0});
    mesh.uv_triangles[t] = {uv, uv, uv};
    result.triangle_chart[t] = chart_at[uv];
  }
  result.num_charts = static_cast<int>(charts.size());
}

StretchFigure figure(std::vector<std::pair<double, double>>& values) {
  StretchFigure f;
  f.median = weighted_quantile(values, 0.5);
  f.p95 = weighted_quantile(values, 0.95);
  f.max = values.empty() ? 1.0 : values.back().first;
  return f;
}

void measure(const UnwrapSurface& surface, const UnwrapOptions& options, UnwrapResult& result) {
  const Mesh& mesh = result.mesh;
  std::vector<std::array<Vec2, 3>> uvs(mesh.triangles.size());
  for (std::size_t t = 0; t < uvs.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) uvs[t][k] = mesh.uvs[mesh.uv_triangles[t][k]];
    const Vec2 a = uvs[t][1] - uvs[t][0], b = uvs[t][2] - uvs[t][0];
    result.packing += 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
  }
  const double scale = std::sqrt(result.packing);  // The surface has unit area.
  result.texels_per_unit = options.resolution * scale / std::sqrt(surface.area);
  std::vector<std::pair<double, double>> stretch, angle, area;
  double l2 = 0.0, total = 0.0;
  for (std::size_t t = 0; t < uvs.size(); ++t) {
    if (!surface.has_shape(static_cast<int>(t))) {
      ++result.num_degenerate;
      continue;
    }
    auto [s1, s2] = singular_values(surface.flat(static_cast<int>(t)), uvs[t]);
    s1 /= scale, s2 /= scale;
    const double weight = surface.areas[t];
    stretch.emplace_back(std::max(s1, 1.0 / s2), weight);
    angle.emplace_back(s1 / s2, weight);
    area.emplace_back(std::max(s1 * s2, 1.0 / (s1 * s2)), weight);
    l2 += weight * 0.5 * (1.0 / (s1 * s1) + 1.0 / (s2 * s2));
    total += weight;
  }
  result.stretch = figure(stretch);
  result.angle_stretch = figure(angle);
  result.area_stretch = figure(area);
  if (total > 0.0) result.l2_stretch = std::sqrt(l2 / total);
}

}  // namespace

void describe(OptionVisitor& v, UnwrapOptions& o) {
  v.visit({"max_normal_angle_deg", "Half opening of the cone that a chart's normals keep to while it grows", "deg",
           between(5, 85)},
          o.max_normal_angle_deg);
  v.visit({"max_stretch", "Charts are cut until 95 % of their area is stretched by no more than this", "",
           between(1.05, 10)},
          o.max_stretch);
  v.visit({"resolution", "Texels along each side of the atlas that the UVs are packed for", "", between(16, 16384)},
          o.resolution);
  v.visit({"gutter_texels", "Least number of texels between two charts", "", between(1, 64)}, o.gutter_texels);
}

UnwrapResult unwrap(const Mesh& mesh, const UnwrapOptions& options, const RunControl& control) {
  check_ranges(options);
  const UnwrapSurface surface = make_unwrap_surface(mesh);
  control.report(0.05);
  std::vector<int> triangle_chart = grow_charts(surface, options.max_normal_angle_deg, control.part(0.05, 0.3));
  smooth_borders(surface, options.max_normal_angle_deg, triangle_chart, control);
  std::vector<FlatChart> charts =
      flatten_all(surface, connected_charts(surface, triangle_chart), options.max_stretch, control.part(0.3, 0.5));
  merge_charts(surface, std::min(kWidestCone_deg, kMergedCone * options.max_normal_angle_deg),
               1.0 + kMergedStretch * (options.max_stretch - 1.0), charts, control);
  control.report(0.7);
  sort_by_area(surface, charts);
  const PackedCharts packed =
      pack_charts(std::move(charts), options.resolution, options.gutter_texels, control.part(0.7, 0.95));
  UnwrapResult result;
  result.mesh = mesh;
  set_uvs(surface, packed.charts, result);
  measure(surface, options, result);
  control.report(1.0);
  return result;
}

}  // namespace patinate
