#include "datasets_synthetic/crackle_relax.h"

#include <algorithm>
#include <cmath>

#include "datasets_synthetic/smooth_noise.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kWaves = 14;  // Purpose of random streams; and the next.
constexpr int kSweeps = 80;           // Over all nodes.
constexpr double kSpring =
    1.5;  // Against one crack's pull, per spacing that a node has moved: softer, and cells of few sides vanish.
constexpr double kLateSpring = 3.0;   // Added to it, where not all cracks come at once.
constexpr double kOneNode = 0.10;     // Cracks that end on another closer than this, in spacings, meet there.
constexpr double kNearest = 0.12;     // Nodes closer than this, in spacings, pull no harder.
constexpr double kWave = 0.20;        // Amplitude of a chord, in spacings.
constexpr double kWaveLength = 0.55;  // In spacings of the thinnest paint.
constexpr double kStepPx = 0.5;

using PlanePoint = std::array<double, 2>;

double distance(const PlanePoint& a, const PlanePoint& b) { return std::hypot(a[0] - b[0], a[1] - b[1]); }

// Where a crack begins, ends, or carries the end of another.
struct Node {
  PlanePoint place = {}, before = {};
  double at_once = 0.0, spacing = 1.0;
  bool is_fixed = false;  // On the border.
  std::vector<int> neighbors = {};
};
struct Stop {
  std::size_t point = 0;  // Point of the crack.
  int node = 0;
};

double sampled(const ImageF& image, const PlanePoint& p) {
  const int x = std::clamp(static_cast<int>(std::lround(p[0])), 0, image.width() - 1),
            y = std::clamp(static_cast<int>(std::lround(p[1])), 0, image.height() - 1);
  return static_cast<double>(image.at(x, y));
}

class Relaxation {
 public:
  Relaxation(const CrackleField& field, const std::vector<std::array<int, 2>>& ends_on, std::vector<Crack>& cracks)
      : field_(field), cracks_(cracks), stops_(cracks.size()) {
    for (std::size_t k = 0; k < cracks.size(); ++k) {
      const std::size_t last = cracks[k].points_px.size() - 1;
      add_end(k, last, ends_on[k][0]);
      add_end(k, 0, ends_on[k][1]);
    }
    for (auto& stops : stops_) {
      std::stable_sort(stops.begin(), stops.end(), [](const Stop& a, const Stop& b) { return a.point < b.point; });
      for (std::size_t i = 1; i < stops.size(); ++i) {
        nodes_[stops[i - 1].node].neighbors.push_back(stops[i].node);
        nodes_[stops[i].node].neighbors.push_back(stops[i - 1].node);
      }
    }
  }

  // Weiszfeld's iteration [1937] for the shortest network, node by node.
  void balance() {
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      for (Node& n : nodes_) {
        if (n.is_fixed || n.at_once <= 0.0 || n.neighbors.size() < 3) continue;
        const double spring = (kSpring + kLateSpring * (1.0 - n.at_once)) / (n.at_once * n.spacing);
        PlanePoint sum{spring * n.before[0], spring * n.before[1]};
        double weights = spring;
        for (const int m : n.neighbors) {
          const PlanePoint& p = nodes_[m].place;
          const double w = 1.0 / std::max(distance(p, n.place), kNearest * n.spacing);
          sum[0] += w * p[0], sum[1] += w * p[1], weights += w;
        }
        n.place = {sum[0] / weights, sum[1] / weights};
      }
    }
  }

  // Points of every crack, moved with its nodes.
  void redraw(const SmoothNoise& wave_x, const SmoothNoise& wave_y) {
    for (std::size_t k = 0; k < cracks_.size(); ++k) {
      Crack& crack = cracks_[k];
      const std::vector<Stop>& stops = stops_[k];
      std::vector<PlanePoint> points;
      std::size_t origin = 0;
      for (std::size_t i = 1; i < stops.size(); ++i) {
        const std::size_t first = stops[i - 1].point, last = stops[i].point;
        if (last == first) continue;
        const Node &a = nodes_[stops[i - 1].node], &b = nodes_[stops[i].node];
        for (std::size_t j = first + (points.empty() ? 0 : 1); j <= last; ++j) {
          if (static_cast<int>(j) == crack.origin) origin = points.size();
          points.push_back(moved(crack.points_px[j], crack.points_px[first], crack.points_px[last], a, b,
                                 static_cast<double>(j - first) / static_cast<double>(last - first), wave_x, wave_y));
        }
      }
      if (points.size() < 2) continue;
      crack.origin = static_cast<int>(origin);
      crack.points_px = std::move(points);
      resample(crack);
    }
  }

 private:
  void add_end(std::size_t crack, std::size_t point, int parent) {
    const PlanePoint& p = cracks_[crack].points_px[point];
    Node node{.place = p,
              .before = p,
              .at_once = sampled(field_.at_once, p),
              .spacing = sampled(field_.spacing_px, p),
              .is_fixed = parent < 0};
    if (parent >= 0) {
      const auto& points = cracks_[parent].points_px;
      const auto nearest =
          std::min_element(points.begin(), points.end(),
                           [&](const PlanePoint& a, const PlanePoint& b) { return distance(a, p) < distance(b, p); });
      if (node.at_once > 0.0) {
        for (const Stop& stop : stops_[parent]) {
          if (distance(nodes_[stop.node].before, *nearest) > kOneNode * node.spacing) continue;
          stops_[crack].push_back({point, stop.node});
          return;
        }
      }
      stops_[parent].push_back({static_cast<std::size_t>(nearest - points.begin()), static_cast<int>(nodes_.size())});
      // A crack stops a pixel short of its parent: that pixel is part of the node.
      if (node.at_once > 0.0) node.place = node.before = *nearest;
    }
    stops_[crack].push_back({point, static_cast<int>(nodes_.size())});
    nodes_.push_back(std::move(node));
  }

  // A point between two nodes: shifted with them, and drawn to a wavy chord as far as cracks come at once.
  [[nodiscard]] PlanePoint moved(const PlanePoint& p, const PlanePoint& first, const PlanePoint& last, const Node& a,
                                 const Node& b, double share, const SmoothNoise& wave_x,
                                 const SmoothNoise& wave_y) const {
    const double w = sampled(field_.at_once, p);
    const bool is_still = w <= 0.0 && a.at_once <= 0.0 && b.at_once <= 0.0;
    if (is_still) return p;
    PlanePoint out{};
    const double spacing = sampled(field_.spacing_px, p), fade = std::pow(4.0 * share * (1.0 - share), 2);
    for (std::size_t c = 0; c < 2; ++c) {
      // Nodes where nothing comes at once stay at their crack's own end.
      const double shift_a = a.place[c] - first[c], shift_b = b.place[c] - last[c];
      const double shifted = p[c] + (1.0 - share) * shift_a * (a.at_once > 0.0 ? 1.0 : 0.0) +
                             share * shift_b * (b.at_once > 0.0 ? 1.0 : 0.0);
      const double from = a.at_once > 0.0 ? a.place[c] : first[c], to = b.at_once > 0.0 ? b.place[c] : last[c];
      const double chord = from + share * (to - from) +
                           kWave * spacing * fade * (c == 0 ? wave_x(out_x(p), out_y(p)) : wave_y(out_x(p), out_y(p)));
      out[c] = (1.0 - w) * shifted + w * chord;
    }
    return out;
  }
  [[nodiscard]] double out_x(const PlanePoint& p) const {
    return std::clamp(p[0], 0.0, field_.spacing_px.width() - 1.0);
  }
  [[nodiscard]] double out_y(const PlanePoint& p) const {
    return std::clamp(p[1], 0.0, field_.spacing_px.height() - 1.0);
  }

  // About half a pixel from point to point again.
  static void resample(Crack& crack) {
    std::vector<PlanePoint> out{crack.points_px.front()};
    int origin = 0;
    for (std::size_t i = 1; i < crack.points_px.size(); ++i) {
      if (static_cast<int>(i) == crack.origin) origin = static_cast<int>(out.size());
      const PlanePoint a = crack.points_px[i - 1], b = crack.points_px[i];
      const int pieces = std::max(1, static_cast<int>(std::lround(distance(a, b) / kStepPx)));
      if (distance(a, b) < 0.2 && i + 1 < crack.points_px.size() && distance(out.back(), b) < 0.35) continue;
      for (int k = 1; k <= pieces; ++k)
        out.push_back({a[0] + (b[0] - a[0]) * k / pieces, a[1] + (b[1] - a[1]) * k / pieces});
    }
    crack.points_px = std::move(out);
    crack.origin = std::min(origin, static_cast<int>(crack.points_px.size()) - 1);
  }

  const CrackleField& field_;
  std::vector<Crack>& cracks_;
  std::vector<Node> nodes_;
  std::vector<std::vector<Stop>> stops_;
};

}  // namespace

void relax_junctions(const CrackleField& field, std::uint64_t seed, const std::vector<std::array<int, 2>>& ends_on,
                     std::vector<Crack>& cracks) {
  Relaxation relaxation(field, ends_on, cracks);
  relaxation.balance();
  const double width = field.spacing_px.width(), height = field.spacing_px.height();
  const double wave =
      std::max(4.0, kWaveLength * static_cast<double>(*std::min_element(field.spacing_px.values().begin(),
                                                                        field.spacing_px.values().end())));
  const SmoothNoise wave_x(seed, kWaves, width, height, wave, wave),
      wave_y(seed, kWaves + 1, width, height, wave, wave);
  relaxation.redraw(wave_x, wave_y);
}

}  // namespace patinate::datasets
