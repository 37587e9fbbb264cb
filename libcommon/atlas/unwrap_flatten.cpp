#include "libcommon/atlas/unwrap_flatten.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "libcommon/atlas/raster.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

namespace {

double side(const Vec2& a, const Vec2& b, const Vec2& p) {
  return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
}

bool cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  if (std::max(a.x(), b.x()) < std::min(c.x(), d.x()) || std::max(c.x(), d.x()) < std::min(a.x(), b.x()) ||
      std::max(a.y(), b.y()) < std::min(c.y(), d.y()) || std::max(c.y(), d.y()) < std::min(a.y(), b.y())) {
    return false;
  }
  const double c_side = side(a, b, c), d_side = side(a, b, d), a_side = side(c, d, a), b_side = side(c, d, b);
  return !(c_side > 0.0 && d_side > 0.0) && !(c_side < 0.0 && d_side < 0.0) && !(a_side > 0.0 && b_side > 0.0) &&
         !(a_side < 0.0 && b_side < 0.0);
}

/// Square cells about as wide as a segment is long, at most some 4 million.
struct Grid {
  Vec2 low;
  double cell = 1.0;
  std::int64_t width = 1;

  Grid(const std::vector<Vec2>& points, const std::vector<std::array<int, 2>>& segments) {
    low = points[segments[0][0]];
    Vec2 high = low;
    double length = 0.0;
    for (const auto& [a, b] : segments) {
      const Vec2 &p = points[a], &q = points[b];
      low = low.cwiseMin(p).cwiseMin(q);
      high = high.cwiseMax(p).cwiseMax(q);
      length += (q - p).norm();
    }
    const double size = (high - low).maxCoeff();
    cell = std::max({length / static_cast<double>(segments.size()), size / 2000.0, 1e-300});
    width = static_cast<std::int64_t>(size / cell) + 1;
  }
  [[nodiscard]] std::int64_t index(double x, double origin) const {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>((x - origin) / cell), 0, width - 1);
  }
};

/// True where two of the segments meet other than in an end that both have by index.
/// @param segments  Pairs of indices into points.
/// Cost: O(segments) for segments of similar length (a grid); exact up to rounding.
bool borders_cross(const std::vector<Vec2>& points, const std::vector<std::array<int, 2>>& segments) {
  if (segments.size() < 2) return false;
  const Grid grid(points, segments);
  std::vector<std::pair<std::int64_t, std::int32_t>> entries;  // (cell, segment)
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Vec2 &p = points[segments[i][0]], &q = points[segments[i][1]];
    const std::int64_t y1 = grid.index(std::max(p.y(), q.y()), grid.low.y()),
                       x1 = grid.index(std::max(p.x(), q.x()), grid.low.x());
    for (std::int64_t y = grid.index(std::min(p.y(), q.y()), grid.low.y()); y <= y1; ++y) {
      for (std::int64_t x = grid.index(std::min(p.x(), q.x()), grid.low.x()); x <= x1; ++x) {
        entries.emplace_back(y * grid.width + x, static_cast<std::int32_t>(i));
      }
    }
  }
  std::sort(entries.begin(), entries.end());
  for (std::size_t begin = 0; begin < entries.size();) {
    std::size_t end = begin + 1;
    while (end < entries.size() && entries[end].first == entries[begin].first) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = i + 1; j < end; ++j) {
        const auto& [a, b] = segments[entries[i].second];
        const auto& [c, d] = segments[entries[j].second];
        if (a == c || a == d || b == c || b == d) continue;
        if (cross(points[a], points[b], points[c], points[d])) {
          return true;
        }
      }
    }
    begin = end;
  }
  return false;
}

constexpr double kStretchShare = 0.95;
constexpr double kSameScale = 1e-30;

std::array<Vec2, 3> corners_of(const FlatChart& chart, std::size_t i) {
  return {chart.points[chart.corners[i][0]], chart.points[chart.corners[i][1]], chart.points[chart.corners[i][2]]};
}

/// Corners become one point where an edge inside the chart connects them: surfaces that only touch at a position come
/// apart.
class CornerJoin {
 public:
  explicit CornerJoin(std::size_t num_corners) : parent_(num_corners) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::size_t find(std::size_t c) {
    while (parent_[c] != c) c = parent_[c] = parent_[parent_[c]];
    return c;
  }
  void join(std::size_t a, std::size_t b) {
    a = find(a), b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

/// Fills corners; returns the border's edges as pairs of points, and the position of each point.
std::vector<std::array<int, 2>> join_corners(const UnwrapSurface& surface, FlatChart& chart,
                                             std::vector<int>& position) {
  const std::size_t n = chart.triangles.size();
  CornerJoin joined(3 * n);
  std::vector<std::array<std::size_t, 2>> border;
  for (std::size_t i = 0; i < n; ++i) {
    const auto t = static_cast<std::size_t>(chart.triangles[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      const int other = surface.neighbors[t][k];
      const auto it =
          other < 0 ? chart.triangles.end() : std::lower_bound(chart.triangles.begin(), chart.triangles.end(), other);
      const std::size_t a = 3 * i + k, b = 3 * i + (k + 1) % 3;
      if (it == chart.triangles.end() || *it != other) {
        border.push_back({a, b});
        continue;
      }
      const auto j = static_cast<std::size_t>(it - chart.triangles.begin());
      const Triangle& other_corners = surface.triangles[other];
      joined.join(a, 3 * j + corner_of(other_corners, surface.triangles[t][k]));
      joined.join(b, 3 * j + corner_of(other_corners, surface.triangles[t][(k + 1) % 3]));
    }
  }
  std::vector<int> point(3 * n, -1);
  chart.corners.resize(n);
  for (std::size_t c = 0; c < 3 * n; ++c) {
    int& p = point[joined.find(c)];
    if (p < 0) {
      p = static_cast<int>(position.size());
      position.push_back(surface.triangles[chart.triangles[c / 3]][c % 3]);
    }
    chart.corners[c / 3][c % 3] = p;
  }
  std::vector<std::array<int, 2>> edges;
  edges.reserve(border.size());
  for (const auto& [a, b] : border) edges.push_back({point[joined.find(a)], point[joined.find(b)]});
  return edges;
}

/// Two points of the border far from each other: farthest from the border's middle, and farthest from that.
std::array<int, 2> choose_pins(const UnwrapSurface& surface, const std::vector<int>& position,
                               const std::vector<std::array<int, 2>>& border) {
  const auto at = [&](int p) -> const Vec3& { return surface.positions[position[static_cast<std::size_t>(p)]]; };
  Vec3 from = Vec3::Zero();
  for (const auto& edge : border) from += at(edge[0]) / static_cast<double>(border.size());
  std::array<int, 2> pins{border[0][0], border[0][1]};
  for (int& pin : pins) {
    double farthest = -1.0;
    for (const auto& edge : border) {
      const double distance = (at(edge[0]) - from).squaredNorm();
      if (distance > farthest) farthest = distance, pin = edge[0];
    }
    from = at(pin);
  }
  if (pins[0] == pins[1]) pins = border[0];
  return pins;
}

/// Minimizes the sum over triangles of |sum_j W_j U_j|^2 / (2 area) with two points fixed; U complex. False if it
/// fails.
bool solve_conformal(const UnwrapSurface& surface, FlatChart& chart, const std::array<int, 2>& pins,
                     double pin_distance) {
  const auto num_points = static_cast<int>(chart.points.size());
  std::vector<int> unknown(chart.points.size());
  int num_unknowns = 0;
  for (int p = 0; p < num_points; ++p) unknown[p] = p == pins[0] || p == pins[1] ? -1 : num_unknowns++;
  std::vector<Eigen::Triplet<std::complex<double>>> entries;
  entries.reserve(chart.triangles.size() * 6);
  Eigen::VectorXcd right = Eigen::VectorXcd::Zero(num_unknowns);
  for (std::size_t i = 0; i < chart.triangles.size(); ++i) {
    const std::array<Vec2, 3> flat = surface.flat(chart.triangles[i]);
    const double twice_area = cross2(flat[1] - flat[0], flat[2] - flat[0]);
    std::array<std::complex<double>, 3> w;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 side = flat[(k + 2) % 3] - flat[(k + 1) % 3];
      w[k] = std::complex<double>(side.x(), side.y());
    }
    for (std::size_t j = 0; j < 3; ++j) {
      const int row = unknown[chart.corners[i][j]];
      if (row < 0) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const int column = unknown[chart.corners[i][k]];
        const std::complex<double> value = std::conj(w[j]) * w[k] / twice_area;
        if (column < 0) {
          if (chart.corners[i][k] == pins[1]) right[row] -= value * pin_distance;
        } else if (column <= row) {
          entries.emplace_back(row, column, value);
        }
      }
    }
  }
  Eigen::SparseMatrix<std::complex<double>> matrix(num_unknowns, num_unknowns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<std::complex<double>>, Eigen::Lower> solver(matrix);
  if (solver.info() != Eigen::Success) return false;
  const Eigen::VectorXcd u = solver.solve(right);
  if (!u.allFinite()) return false;
  for (std::size_t p = 0; p < chart.points.size(); ++p) {
    if (unknown[p] >= 0) chart.points[p] = Vec2(u[unknown[p]].real(), u[unknown[p]].imag());
  }
  chart.points[pins[0]] = Vec2(0.0, 0.0);
  chart.points[pins[1]] = Vec2(pin_distance, 0.0);
  return true;
}

void project(const UnwrapSurface& surface, FlatChart& chart, const std::vector<int>& position) {
  Vec3 axis = Vec3::Zero();
  for (int t : chart.triangles) axis += surface.areas[t] * surface.normals[t];
  if (!(axis.norm() > 0.0)) axis = surface.normals[chart.triangles[0]];
  axis.normalize();
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);
  for (std::size_t p = 0; p < position.size(); ++p) {
    const Vec3& at = surface.positions[position[p]];
    chart.points[p] = Vec2(x.dot(at), y.dot(at));
  }
}

/// Every triangle counter-clockwise, every fan inside the chart once around and those at its border less than that.
bool is_immersed(const FlatChart& chart, const std::vector<std::array<int, 2>>& border) {
  std::vector<double> turn(chart.points.size(), 0.0);
  for (std::size_t i = 0; i < chart.corners.size(); ++i) {
    const std::array<Vec2, 3> p = corners_of(chart, i);
    const double twice_area = cross2(p[1] - p[0], p[2] - p[0]);
    if (!(twice_area > 0.0)) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      turn[chart.corners[i][k]] += std::atan2(twice_area, (p[(k + 1) % 3] - p[k]).dot(p[(k + 2) % 3] - p[k]));
    }
  }
  constexpr double kTurn = 2.0 * std::numbers::pi;
  if (std::any_of(border.begin(), border.end(), [&](const auto& edge) { return !(turn[edge[0]] < kTurn); }))
    return false;
  return std::all_of(turn.begin(), turn.end(), [&](double angle) { return angle < 1.5 * kTurn; });
}

bool scale_to_surface(const UnwrapSurface& surface, FlatChart& chart) {
  double in_plane = 0.0, on_surface = 0.0;
  for (std::size_t i = 0; i < chart.triangles.size(); ++i) {
    const std::array<Vec2, 3> p = corners_of(chart, i);
    in_plane += 0.5 * cross2(p[1] - p[0], p[2] - p[0]);
    on_surface += surface.areas[chart.triangles[i]];
  }
  if (!(in_plane > kSameScale)) return false;
  const double scale = std::sqrt(on_surface / in_plane);
  for (Vec2& p : chart.points) p *= scale;
  return true;
}

bool is_stretched(const UnwrapSurface& surface, const FlatChart& chart, double max_stretch) {
  std::vector<std::pair<double, double>> stretch;
  stretch.reserve(chart.triangles.size());
  for (std::size_t i = 0; i < chart.triangles.size(); ++i) {
    const auto [s1, s2] = singular_values(surface.flat(chart.triangles[i]), corners_of(chart, i));
    stretch.emplace_back(std::max(s1, 1.0 / s2), surface.areas[chart.triangles[i]]);
  }
  return !(weighted_quantile(stretch, kStretchShare) <= max_stretch);
}

FlatStatus judge(const UnwrapSurface& surface, FlatChart& chart, const std::vector<std::array<int, 2>>& border,
                 double max_stretch) {
  if (!is_immersed(chart, border) || !scale_to_surface(surface, chart)) return FlatStatus::Flipped;
  if (is_stretched(surface, chart, max_stretch)) return FlatStatus::Stretched;
  return borders_cross(chart.points, border) ? FlatStatus::Overlapping : FlatStatus::Good;
}

}  // namespace

std::array<double, 2> singular_values(const std::array<Vec2, 3>& from, const std::array<Vec2, 3>& to) {
  Eigen::Matrix2d a, b;
  a << from[1] - from[0], from[2] - from[0];
  b << to[1] - to[0], to[2] - to[0];
  const double det = a.determinant();
  if (!(std::abs(det) > 0.0)) return {1.0, 1.0};
  Eigen::Matrix2d inverse;
  inverse << a(1, 1), -a(0, 1), -a(1, 0), a(0, 0);
  const Eigen::Matrix2d j = b * inverse / det;
  // For a 2 x 2 matrix: half the sum and the difference of the lengths of its conformal and anticonformal parts.
  const double conformal = std::hypot(j(0, 0) + j(1, 1), j(1, 0) - j(0, 1));
  const double anticonformal = std::hypot(j(0, 0) - j(1, 1), j(1, 0) + j(0, 1));
  return {0.5 * (conformal + anticonformal), 0.5 * std::abs(conformal - anticonformal)};
}

double weighted_quantile(std::vector<std::pair<double, double>>& value_and_weight, double share) {
  std::sort(value_and_weight.begin(), value_and_weight.end());
  double total = 0.0, sum = 0.0;
  for (const auto& [value, weight] : value_and_weight) total += weight;
  for (const auto& [value, weight] : value_and_weight) {
    sum += weight;
    if (weight > 0.0 && sum >= share * total) return value;
  }
  return 1.0;
}

FlatChart flatten_chart(const UnwrapSurface& surface, std::vector<int> triangles, double max_stretch) {
  FlatChart chart;
  chart.triangles = std::move(triangles);
  if (chart.triangles.size() == 1) {
    const std::array<Vec2, 3> flat = surface.flat(chart.triangles[0]);
    chart.corners = {{0, 1, 2}};
    chart.points.assign(flat.begin(), flat.end());
    return chart;
  }
  std::vector<int> position;
  const std::vector<std::array<int, 2>> border = join_corners(surface, chart, position);
  chart.points.assign(position.size(), Vec2::Zero());
  chart.status = FlatStatus::Closed;
  if (border.empty()) return chart;
  const std::array<int, 2> pins = choose_pins(surface, position, border);
  chart.status = FlatStatus::Flipped;
  if (solve_conformal(surface, chart, pins, 1.0)) chart.status = judge(surface, chart, border, max_stretch);
  if (chart.status == FlatStatus::Good || chart.status == FlatStatus::Stretched) return chart;
  FlatChart planar = chart;
  planar.is_planar = true;
  project(surface, planar, position);
  planar.status = judge(surface, planar, border, max_stretch);
  return planar.status == FlatStatus::Good ? planar : chart;
}

}  // namespace patinate
