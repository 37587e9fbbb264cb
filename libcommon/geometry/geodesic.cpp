#include "libcommon/geometry/geodesic.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <span>
#include <utility>

#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kMaxStretch =
    1.5;  ///< Two sources farther apart than this times the edge before them are not one line.

Vec3 unit_normal(const Mesh& mesh, int triangle) {
  const Vec3 n = area_vector(mesh, triangle);
  return n.norm() > 0.0 ? Vec3(n.normalized()) : Vec3(Vec3::UnitZ());
}

Vec3 nearest_on_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 d = b - a;
  const double squared = d.squaredNorm();
  return squared > 0.0 ? Vec3(a + std::clamp((p - a).dot(d) / squared, 0.0, 1.0) * d) : a;
}

/// Whether the way from `p` to `s` goes through the segment a b; all in one plane with the given normal.
bool passes_between(const Vec3& p, const Vec3& s, const Vec3& a, const Vec3& b, const Vec3& normal) {
  const Vec3 way = normal.cross(s - p);
  const double slack = 1e-9 * (a - b).norm() * way.norm();
  const double at_a = way.dot(a - p), at_b = way.dot(b - p);
  return std::min(at_a, at_b) <= slack && std::max(at_a, at_b) >= -slack;
}

/// Triangles around each position.
class Fans {
 public:
  explicit Fans(const Mesh& mesh) : begin_(mesh.positions.size() + 1, 0), triangles_(3 * mesh.triangles.size()) {
    for (const Triangle& t : mesh.triangles) {
      for (const int corner : t) ++begin_[static_cast<std::size_t>(corner) + 1];
    }
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    for (int i = 0; i < mesh.num_triangles(); ++i) {
      for (const int corner : mesh.triangles[i]) {
        triangles_[next[static_cast<std::size_t>(corner)]++] = i;
      }
    }
  }
  [[nodiscard]] std::span<const int> around(int vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    return std::span(triangles_)
        .subspan(static_cast<std::size_t>(begin_[v]), static_cast<std::size_t>(begin_[v + 1] - begin_[v]));
  }

 private:
  std::vector<int> begin_;
  std::vector<int> triangles_;
};

}  // namespace

GeodesicDistance::GeodesicDistance(const Mesh& mesh, const std::vector<GeodesicSource>& sources,
                                   const RunControl& control)
    : mesh_(mesh) {
  if (sources.empty()) throw InvalidInput("distance: there is nothing to measure from");
  for (int t = 0; t < mesh.num_triangles(); ++t) normals_.push_back(unit_normal(mesh, t));
  arrivals_.assign(mesh.positions.size(), Arrival{.distance = kInfinite});
  for (const GeodesicSource& s : sources) {
    for (const int corner : mesh.triangles[s.triangle]) {
      Arrival& arrival = arrivals_[corner];
      const Vec3 to_source = s.position - mesh.positions[corner];
      if (!(to_source.norm() < arrival.distance)) continue;
      arrival = {to_source.norm(), 0.0, to_source, normals_[s.triangle]};
    }
  }
  march(control);
}

Vec3 GeodesicDistance::source_in(int vertex, const Vec3& normal) const {
  const Arrival& a = arrivals_[vertex];
  return mesh_.positions[vertex] + Eigen::Quaterniond::FromTwoVectors(a.normal, normal) * a.to_source;
}

GeodesicDistance::Arrival GeodesicDistance::arrive(int triangle, int target, int from, int other,
                                                   bool is_other_known) const {
  const Vec3& normal = normals_[triangle];
  const auto position = [&](int v) { return mesh_.positions[v]; };
  const Vec3 p = position(target), a = position(from), b = position(other);
  const Arrival &at_a = arrivals_[from], &at_b = arrivals_[other];
  // Along the edge: the way bends at `from`.
  Arrival best{at_a.distance + (p - a).norm(), at_a.distance, a - p, normal};
  const auto straight = [&](const Vec3& source, double before) {
    if (!passes_between(p, source, a, b, normal)) return;
    const double distance = before + (source - p).norm();
    if (distance < best.distance) best = {distance, before, source - p, normal};
  };
  const Vec3 source_a = source_in(from, normal);
  straight(source_a, at_a.before);
  if (is_other_known && std::abs(at_a.before - at_b.before) <= 1e-9 * at_a.distance) {
    const Vec3 source_b = source_in(other, normal);
    if ((source_a - source_b).norm() <= kMaxStretch * (a - b).norm()) {
      straight(nearest_on_segment(source_a, source_b, p), at_a.before);
    }
  }
  return best;
}

void GeodesicDistance::march(const RunControl& control) {
  const Fans fans(mesh_);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::vector<bool> is_final(arrivals_.size(), false);
  for (std::size_t i = 0; i < arrivals_.size(); ++i) {
    if (arrivals_[i].distance < kInfinite) open.emplace(arrivals_[i].distance, static_cast<int>(i));
  }
  for (std::size_t num_final = 0; !open.empty();) {
    const auto [distance, v] = open.top();
    open.pop();
    if (is_final[v]) continue;
    is_final[v] = true;
    if (++num_final % 4096 == 0) control.throw_if_stopped();
    for (const int t : fans.around(v)) {
      const Triangle& corners = mesh_.triangles[t];
      for (std::size_t k = 0; k < 3; ++k) {
        const int w = corners[k];
        if (w == v || is_final[w]) continue;
        const int u = corners[(k + 1) % 3] == v ? corners[(k + 2) % 3] : corners[(k + 1) % 3];
        const Arrival arrival = arrive(t, w, v, u, is_final[u]);
        if (!(arrival.distance < arrivals_[w].distance)) continue;
        arrivals_[w] = arrival;
        open.emplace(arrival.distance, w);
      }
    }
  }
  control.report(1.0);
}

double GeodesicDistance::at(int triangle, const Vec3& p) const {
  const Triangle& corners = mesh_.triangles[triangle];
  const Vec3& normal = normals_[triangle];
  double best = kInfinite;
  for (std::size_t k = 0; k < 3; ++k) {
    const int a = corners[k], b = corners[(k + 1) % 3];
    const Arrival &at_a = arrivals_[a], &at_b = arrivals_[b];
    if (!(at_a.distance < kInfinite) || !(at_b.distance < kInfinite)) continue;
    const Vec3 source_a = source_in(a, normal), source_b = source_in(b, normal);
    best = std::min({best, at_a.before + (source_a - p).norm(), at_b.before + (source_b - p).norm()});
    const double edge = (mesh_.positions[a] - mesh_.positions[b]).norm();
    if (std::abs(at_a.before - at_b.before) <= 1e-9 * at_a.distance &&
        (source_a - source_b).norm() <= kMaxStretch * edge) {
      best = std::min(best, at_a.before + (nearest_on_segment(source_a, source_b, p) - p).norm());
    }
  }
  return best;
}

}  // namespace patinate
