#include "libcommon/atlas/unwrap_charts.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <tuple>

namespace patinate {

namespace {

constexpr int kFree = -1;
constexpr int kBlocked = -2;
constexpr double kAnyNormal = -2.0;  ///< Least cosine without a cone.
constexpr double kFlatCost = 0.15;   ///< Cost of a length where the surface does not turn, which keeps charts round.
constexpr double kCreaseCost = 4.0;  ///< Extra cost of crossing an edge, per 1 - cos of its angle.
constexpr double kSpeck = 3e-4;  ///< Share of the area below which what no cone takes is given to the charts around.
constexpr int kMaxRounds = 40;
constexpr int kSettledRounds = 4;  ///< Rounds of Lloyd's iteration after the last new seed.
constexpr int kSplitRounds = 4;
constexpr int kMaxSmoothing = 20;

struct Seed {
  int triangle;
  Vec3 axis;
};

/// Gives free triangles to the chart with the cheapest path, from all triangles that have one.
class Flood {
 public:
  Flood(const UnwrapSurface& surface, const std::vector<Seed>& seeds, double least_cos, std::vector<int>& chart,
        const RunControl& control = {})
      : surface_(surface), seeds_(seeds), least_cos_(least_cos), chart_(chart), control_(control) {}

  void run_from_seeds() {
    for (std::size_t c = 0; c < seeds_.size(); ++c) {
      int& chart = chart_[seeds_[c].triangle];
      if (chart == kFree) chart = static_cast<int>(c);
    }
    for (std::size_t c = 0; c < seeds_.size(); ++c) {
      if (chart_[seeds_[c].triangle] == static_cast<int>(c)) push_neighbors(seeds_[c].triangle, 0.0);
    }
    spread();
  }
  void run_from_charts() {
    for (int t = 0; t < surface_.num_triangles(); ++t) {
      if (chart_[t] >= 0) push_neighbors(t, 0.0);
    }
    spread();
  }

 private:
  using Entry = std::tuple<double, int, int>;  ///< Cost, triangle, chart.

  void push_neighbors(int triangle, double cost) {
    const auto t = static_cast<std::size_t>(triangle);
    const int chart = chart_[t];
    const Vec3& axis = seeds_[chart].axis;
    for (int neighbor : surface_.neighbors[t]) {
      if (neighbor < 0 || chart_[neighbor] != kFree) continue;
      const auto n = static_cast<std::size_t>(neighbor);
      const double facing = axis.dot(surface_.normals[n]);
      if (facing < least_cos_) continue;
      const double length = (surface_.centroids[n] - surface_.centroids[t]).norm();
      const double crease = 1.0 + kCreaseCost * (1.0 - surface_.normals[n].dot(surface_.normals[t]));
      queue_.emplace(cost + length * crease * (1.0 + kFlatCost - facing), neighbor, chart);
    }
  }
  void spread() {
    constexpr std::size_t kTrianglesALook = 4096;
    for (std::size_t i = 0; !queue_.empty(); ++i) {
      if (i % kTrianglesALook == 0) control_.throw_if_stopped();
      const auto [cost, triangle, chart] = queue_.top();
      queue_.pop();
      if (chart_[triangle] != kFree) continue;
      chart_[triangle] = chart;
      push_neighbors(triangle, cost);
    }
  }

  const UnwrapSurface& surface_;
  const std::vector<Seed>& seeds_;
  double least_cos_;
  std::vector<int>& chart_;
  RunControl control_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

/// The triangle nearest to the middle of a chart, and its axis.
Seed center_of(const UnwrapSurface& surface, const std::vector<int>& triangles) {
  Vec3 middle = Vec3::Zero();
  double area = 0.0;
  for (int t : triangles) {
    middle += surface.areas[t] * surface.centroids[t];
    area += surface.areas[t];
  }
  Seed seed{triangles[0], chart_axis(surface, triangles)};
  if (!(area > 0.0)) return seed;
  middle /= area;
  double least = -1.0;
  for (int t : triangles) {
    const double distance = (surface.centroids[t] - middle).squaredNorm();
    if (least >= 0.0 && !(distance < least)) continue;
    least = distance;
    seed.triangle = t;
  }
  return seed;
}

/// The triangle of a set that most steps part from its border; the first where it has none.
int deepest_of(const UnwrapSurface& surface, const std::vector<int>& triangles) {
  const auto index = [&](int t) {
    const auto it = std::lower_bound(triangles.begin(), triangles.end(), t);
    return it != triangles.end() && *it == t ? it - triangles.begin() : std::ptrdiff_t{-1};
  };
  std::vector<bool> is_seen(triangles.size(), false);
  std::vector<int> ring;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& neighbors = surface.neighbors[triangles[i]];
    if (std::all_of(neighbors.begin(), neighbors.end(), [&](int n) { return n >= 0 && index(n) >= 0; })) continue;
    is_seen[i] = true;
    ring.push_back(triangles[i]);
  }
  int deepest = triangles[0];
  while (!ring.empty()) {
    deepest = *std::min_element(ring.begin(), ring.end());
    std::vector<int> next;
    for (int t : ring) {
      for (int n : surface.neighbors[t]) {
        const std::ptrdiff_t i = n < 0 ? -1 : index(n);
        if (i < 0 || is_seen[i]) continue;
        is_seen[i] = true;
        next.push_back(n);
      }
    }
    ring = std::move(next);
  }
  return deepest;
}

/// Connected sets of free triangles that deserve a chart: no specks beside one.
std::vector<std::vector<int>> uncovered_parts(const UnwrapSurface& surface, const std::vector<int>& chart) {
  std::vector<int> free;
  for (int t = 0; t < surface.num_triangles(); ++t) {
    if (chart[t] == kFree) free.push_back(t);
  }
  std::vector<std::vector<int>> parts = connected_parts(surface, free, chart);
  std::erase_if(parts, [&](const std::vector<int>& part) {
    double area = 0.0;
    bool is_beside = false;
    for (int t : part) {
      area += surface.areas[t];
      for (int n : surface.neighbors[t]) is_beside |= n >= 0 && chart[n] >= 0;
    }
    return is_beside && area < kSpeck;
  });
  return parts;
}

std::vector<Seed> centers_of(const UnwrapSurface& surface, const std::vector<int>& chart) {
  std::vector<Seed> seeds;
  for (const std::vector<int>& triangles : triangles_by_chart(chart)) seeds.push_back(center_of(surface, triangles));
  return seeds;
}

double least_cosine(double angle_deg) { return std::cos(angle_deg * std::numbers::pi / 180.0); }

/// Weight of an edge as a border, by how sharp it is.
double border_weight(const UnwrapSurface& surface, std::size_t a, std::size_t b) {
  return 0.2 + 0.8 * std::clamp(surface.normals[a].dot(surface.normals[b]), 0.0, 1.0);
}

/// The chart that would shorten borders by taking triangle t; its own if none.
int better_chart(const UnwrapSurface& surface, const std::vector<Vec3>& axes, double least_cos,
                 const std::vector<int>& chart, std::size_t t) {
  double kept = 0.0;
  int num_kept = 0;
  std::array<double, 3> shared{};
  for (std::size_t k = 0; k < 3; ++k) {
    const int n = surface.neighbors[t][k];
    if (n < 0 || chart[n] < 0) continue;
    const Triangle& corners = surface.triangles[t];
    shared[k] = border_weight(surface, t, static_cast<std::size_t>(n)) *
                (surface.positions[corners[k]] - surface.positions[corners[(k + 1) % 3]]).norm();
    if (chart[n] == chart[t]) kept += shared[k], ++num_kept;
  }
  int best = chart[t];
  if (num_kept > 1) return best;
  double most = kept * (1.0 + 1e-9);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(shared[k] > 0.0)) continue;
    const int candidate = chart[surface.neighbors[t][k]];
    if (candidate == chart[t] || axes[candidate].dot(surface.normals[t]) < least_cos) continue;
    double gained = 0.0;
    for (std::size_t j = 0; j < 3; ++j) {
      if (shared[j] > 0.0 && chart[surface.neighbors[t][j]] == candidate) gained += shared[j];
    }
    if (gained > most) most = gained * (1.0 + 1e-9), best = candidate;
  }
  return best;
}

}  // namespace

Vec3 chart_axis(const UnwrapSurface& surface, const std::vector<int>& triangles) {
  Vec3 axis = Vec3::Zero();
  for (int t : triangles) axis += surface.areas[t] * surface.normals[t];
  const double length = axis.norm();
  return length > 1e-12 ? Vec3(axis / length) : surface.normals[triangles[0]];
}

std::vector<std::vector<int>> triangles_by_chart(const std::vector<int>& triangle_chart) {
  std::vector<std::vector<int>> charts;
  for (std::size_t t = 0; t < triangle_chart.size(); ++t) {
    if (triangle_chart[t] < 0) continue;
    const auto c = static_cast<std::size_t>(triangle_chart[t]);
    if (charts.size() <= c) charts.resize(c + 1);
    charts[c].push_back(static_cast<int>(t));
  }
  std::erase_if(charts, [](const std::vector<int>& chart) { return chart.empty(); });
  return charts;
}

std::vector<int> grow_charts(const UnwrapSurface& surface, double max_normal_angle_deg, const RunControl& control) {
  const double least_cos = least_cosine(max_normal_angle_deg);
  std::vector<int> untouched(surface.triangles.size(), kFree), chart = untouched;
  for (std::size_t t = 0; t < chart.size(); ++t) {
    if (surface.is_point[t]) untouched[t] = kBlocked;
  }
  std::vector<Seed> seeds;
  for (int round = 0, settled = 0; round < kMaxRounds && settled < kSettledRounds; ++round) {
    control.throw_if_stopped();
    chart = untouched;
    Flood(surface, seeds, least_cos, chart, control).run_from_seeds();
    const std::vector<std::vector<int>> parts = uncovered_parts(surface, chart);
    settled = parts.empty() ? settled + 1 : 0;
    control.throw_if_stopped();
    seeds = centers_of(surface, chart);
    for (const std::vector<int>& part : parts) {
      control.throw_if_stopped();
      const int t = deepest_of(surface, part);
      seeds.push_back({t, surface.normals[t]});
    }
    control.report(std::min(0.9, 0.05 * (round + 1)));
  }
  chart = untouched;
  Flood(surface, seeds, least_cos, chart, control).run_from_seeds();
  Flood(surface, seeds, kAnyNormal, chart, control).run_from_charts();
  int num_charts = static_cast<int>(seeds.size());
  for (const std::vector<int>& part : uncovered_parts(surface, chart)) {
    for (int t : part) chart[t] = num_charts;
    ++num_charts;
  }
  std::replace(chart.begin(), chart.end(), kBlocked, -1);
  return chart;
}

void smooth_borders(const UnwrapSurface& surface, double max_normal_angle_deg, std::vector<int>& triangle_chart,
                    const RunControl& control) {
  const double least_cos = least_cosine(max_normal_angle_deg);
  int num_charts = 0;
  for (int c : triangle_chart) num_charts = std::max(num_charts, c + 1);
  std::vector<Vec3> axes(static_cast<std::size_t>(num_charts), Vec3::Zero());
  for (std::size_t t = 0; t < triangle_chart.size(); ++t) {
    if (triangle_chart[t] >= 0) axes[triangle_chart[t]] += surface.areas[t] * surface.normals[t];
  }
  for (Vec3& axis : axes) axis.normalize();
  for (int sweep = 0; sweep < kMaxSmoothing; ++sweep) {
    control.throw_if_stopped();
    bool has_changed = false;
    for (std::size_t t = 0; t < triangle_chart.size(); ++t) {
      if (triangle_chart[t] < 0) continue;
      const int better = better_chart(surface, axes, least_cos, triangle_chart, t);
      has_changed |= better != triangle_chart[t];
      triangle_chart[t] = better;
    }
    if (!has_changed) return;
  }
}

ChartSplitter::ChartSplitter(const UnwrapSurface& surface)
    : surface_(surface), label_(surface.triangles.size(), kBlocked) {}

std::vector<std::vector<int>> ChartSplitter::split(const std::vector<int>& triangles) {
  const auto reset = [&](int value) {
    for (int t : triangles) label_[t] = value;
  };
  const auto farthest_from = [&](int from) {
    const Vec3& c = surface_.centroids[from];
    int farthest = triangles[0] == from ? triangles[1] : triangles[0];
    double most = -1.0;
    for (int t : triangles) {
      const double distance = (surface_.centroids[t] - c).squaredNorm();
      if (t != from && distance > most) most = distance, farthest = t;
    }
    return farthest;
  };
  const int first = farthest_from(center_of(surface_, triangles).triangle);
  const int second = farthest_from(first);
  std::vector<Seed> seeds{{first, surface_.normals[first]}, {second, surface_.normals[second]}};
  std::array<std::vector<int>, 2> halves;
  for (int round = 0; round < kSplitRounds; ++round) {
    reset(kFree);
    Flood(surface_, seeds, kAnyNormal, label_).run_from_seeds();
    for (std::vector<int>& half : halves) half.clear();
    for (int t : triangles) halves[label_[static_cast<std::size_t>(t)]].push_back(t);
    for (std::size_t i = 0; i < 2; ++i) seeds[i] = center_of(surface_, halves[i]);
  }
  std::vector<std::vector<int>> parts;
  for (const std::vector<int>& half : halves) {
    for (std::vector<int>& part : connected_parts(surface_, half, label_)) parts.push_back(std::move(part));
  }
  reset(kBlocked);
  return parts;
}

}  // namespace patinate
