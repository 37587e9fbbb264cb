#include "libcommon/atlas/unwrap_merge.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "libcommon/atlas/unwrap_charts.h"

namespace patinate {

namespace {

constexpr double kConeShare = 0.95;
constexpr double kLeastShare = 0.15;  ///< Of the smaller chart's border that must be shared: no chains of charts.
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
      if (length >= kLeastShare * border) sorted.emplace_back(length, other);
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

}  // namespace

void merge_charts(const UnwrapSurface& surface, double max_normal_angle_deg, double max_stretch,
                  std::vector<FlatChart>& charts, const RunControl& control) {
  Merger(surface, max_normal_angle_deg, max_stretch, charts).run(control);
}

}  // namespace patinate
