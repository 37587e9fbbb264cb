#include "libcommon/geometry/mesh_refine.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

namespace {

std::uint64_t edge_key(int a, int b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint64_t>(std::max(a, b));
}

struct LongEdge {
  std::uint64_t key = 0;
  double squared_length = 0.0;
  int num_triangles = 0;
};

/// Edges longer than `max_edge`, the longest first.
std::vector<LongEdge> find_long_edges(const Mesh& mesh, double max_edge) {
  std::vector<LongEdge> edges;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const double squared = (mesh.positions[std::max(a, b)] - mesh.positions[std::min(a, b)]).squaredNorm();
      if (squared > max_edge * max_edge) edges.push_back({edge_key(a, b), squared, 1});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const LongEdge& a, const LongEdge& b) { return a.key < b.key; });
  std::size_t num = 0;
  for (const LongEdge& e : edges) {
    if (num > 0 && edges[num - 1].key == e.key) {
      ++edges[num - 1].num_triangles;
    } else {
      edges[num++] = e;
    }
  }
  edges.resize(num);
  std::sort(edges.begin(), edges.end(), [](const LongEdge& a, const LongEdge& b) {
    return a.squared_length != b.squared_length ? a.squared_length > b.squared_length : a.key < b.key;
  });
  return edges;
}

/// Midpoints of pairs of entries of one array, each made once.
template <class Vector>
class Midpoints {
 public:
  /// @param num_edges  How many it will be asked for, about.
  Midpoints(std::vector<Vector>& values, std::size_t num_edges) : values_(values) { made_.reserve(num_edges); }
  int operator()(int a, int b, bool normalize = false) {
    if (a == b) return a;
    const auto [entry, is_new] = made_.try_emplace(edge_key(a, b), static_cast<int>(values_.size()));
    if (is_new) {
      const Vector low = values_[std::min(a, b)];
      const Vector high = values_[std::max(a, b)];
      Vector mid = 0.5 * (low + high);
      if (normalize) mid = mid.norm() > 1e-9 ? Vector(mid / mid.norm()) : low;
      values_.push_back(mid);
    }
    return entry->second;
  }

  /// Both ends of every midpoint's edge, in the order in which they were made.
  void list_ends(std::vector<std::array<int, 2>>& ends) const {
    const std::size_t before = ends.size(), first = values_.size() - made_.size();
    ends.resize(before + made_.size());
    for (const auto& [key, index] : made_) {
      ends[before + static_cast<std::size_t>(index) - first] = {static_cast<int>(key >> 32),
                                                                static_cast<int>(key & 0xffffffffu)};
    }
  }

  /// Adds offset(a, b) to every midpoint.
  template <class Offset>
  void move_by(Offset&& offset) {
    for (const auto& [key, index] : made_) {
      values_[index] += offset(static_cast<int>(key >> 32), static_cast<int>(key & 0xffffffffu));
    }
  }

 private:
  std::vector<Vector>& values_;
  std::unordered_map<std::uint64_t, int> made_;
};

constexpr double kSmoothCosine = 0.7;  ///< Cosine of 45 degrees: sharper is a crease.

/// A normal for every corner: the one that the mesh has if it is within 45 degrees of its triangle's, else the
/// angle-weighted mean over the triangles around the position that are.
Mesh with_corner_normals(Mesh mesh) {
  const bool has_normals = mesh.normal_triangles.size() == mesh.triangles.size();
  std::vector<Vec3> face(mesh.triangles.size());
  std::vector<std::vector<int>> around(mesh.positions.size());
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const Vec3 area = area_vector(mesh, t);
    face[t] = area.norm() > 0.0 ? Vec3(area.normalized()) : Vec3(Vec3::Zero());
    for (int p : mesh.triangles[t]) around[p].push_back(t);
  }
  const auto angle_at = [&mesh](int t, int position) {
    const Triangle& c = mesh.triangles[t];
    const std::size_t k = c[0] == position ? 0 : c[1] == position ? 1 : 2;
    const auto at = [&](std::size_t i) -> const Vec3& { return mesh.positions[c[i % 3]]; };
    const Vec3 a = at(k + 1) - at(k), b = at(k + 2) - at(k);
    return std::atan2(a.cross(b).norm(), a.dot(b));
  };
  std::vector<Vec3> normals(mesh.triangles.size() * 3);
  std::vector<Triangle> normal_triangles(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3& normal = normals[3 * t + k];
      normal_triangles[t][k] = static_cast<int>(3 * t + k);
      if (has_normals) normal = mesh.normals[mesh.normal_triangles[t][k]];
      if (has_normals && normal.dot(face[t]) > kSmoothCosine) continue;
      const int position = mesh.triangles[t][k];
      Vec3 sum = Vec3::Zero();
      for (int other : around[position]) {
        const Vec3& n = face[other];
        if (n.dot(face[t]) > kSmoothCosine) sum += angle_at(other, position) * n;
      }
      normal = sum.norm() > 1e-9 ? Vec3(sum.normalized()) : Vec3(Vec3::UnitZ());
    }
  }
  mesh.normals = std::move(normals);
  mesh.normal_triangles = std::move(normal_triangles);
  return mesh;
}

/// Offsets of the midpoints of some edges.
class Bulges {
 public:
  /// Visits every side of every triangle that is one of the edges.
  Bulges(const Mesh& mesh, const std::unordered_set<std::uint64_t>& edges) {
    if (edges.empty()) return;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
      const Triangle& corners = mesh.triangles[t];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        if (!edges.contains(edge_key(corners[k], corners[next]))) continue;
        const bool is_rising = corners[k] < corners[next];
        add(mesh, t, is_rising ? k : next, is_rising ? next : k);
      }
    }
  }

  [[nodiscard]] Vec3 of(int a, int b) const {
    const auto found = edges_.find(edge_key(a, b));
    return found != edges_.end() && found->second.is_smooth ? found->second.bulge : Vec3(Vec3::Zero());
  }

 private:
  struct Edge {
    Vec3 normal_a, normal_b;
    Vec3 bulge;
    bool is_smooth;
  };

  void add(const Mesh& mesh, int t, std::size_t a, std::size_t b) {
    const Triangle& corners = mesh.triangles[t];
    const Triangle& normals = mesh.normal_triangles[t];
    const Vec3& na = mesh.normals[normals[a]];
    const Vec3& nb = mesh.normals[normals[b]];
    const Vec3 area = area_vector(mesh, t);
    const bool fits = std::min(area.dot(na), area.dot(nb)) > kSmoothCosine * area.norm();
    const auto [entry, is_new] = edges_.try_emplace(edge_key(corners[a], corners[b]));
    Edge& edge = entry->second;
    if (is_new) {
      const Vec3 ab = mesh.positions[corners[b]] - mesh.positions[corners[a]];
      edge = {na, nb, (ab.dot(nb) * nb - ab.dot(na) * na) / 8.0, fits};
    } else {
      edge.is_smooth =
          edge.is_smooth && fits && (edge.normal_a - na).norm() < 1e-3 && (edge.normal_b - nb).norm() < 1e-3;
    }
  }

  std::unordered_map<std::uint64_t, Edge> edges_;
};

/// A triangle pattern over corners 0-2 and edge midpoints 3 (0-1), 4 (1-2), 5 (2-0).
using Pattern = std::vector<Triangle>;

/// How a triangle with these split edges is cut; of the quad that two split edges leave, along the shorter diagonal.
Pattern pattern_of(const std::array<bool, 3>& is_split, const std::array<Vec3, 3>& p) {
  const int count = int{is_split[0]} + int{is_split[1]} + int{is_split[2]};
  if (count == 0) return {{0, 1, 2}};
  if (count == 3) return {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};
  // Rotated so that edge 0-1 is the split one (count 1), or 2-0 the one that is not (count 2).
  int r = 0;
  while (count == 1 ? !is_split[r] : is_split[(r + 2) % 3]) ++r;
  const auto c = [r](int k) { return (k + r) % 3; };
  const auto m = [r](int k) { return 3 + (k + r) % 3; };
  if (count == 1) return {{c(0), m(0), c(2)}, {m(0), c(1), c(2)}};
  const auto at = [&](int k) -> const Vec3& { return p[c(k)]; };
  const double from_corner_0 = (0.5 * (at(1) + at(2)) - at(0)).squaredNorm();
  const double from_corner_2 = (0.5 * (at(0) + at(1)) - at(2)).squaredNorm();
  if (from_corner_0 <= from_corner_2) return {{m(0), c(1), m(1)}, {c(0), m(0), m(1)}, {c(0), m(1), c(2)}};
  return {{m(0), c(1), m(1)}, {c(0), m(0), c(2)}, {m(0), m(1), c(2)}};
}

/// One pass: splits the given edges wherever they occur.
void split_edges(Mesh& mesh, const std::unordered_set<std::uint64_t>& is_split, RefineShape shape,
                 std::vector<std::array<int, 2>>& parents) {
  const Bulges bulges(mesh, shape == RefineShape::Curved ? is_split : std::unordered_set<std::uint64_t>{});
  Midpoints<Vec3> mid_position(mesh.positions, is_split.size());
  Midpoints<Vec2> mid_uv(mesh.uvs, is_split.size());
  Midpoints<Vec3> mid_normal(mesh.normals, is_split.size());
  const bool has_uvs = mesh.has_uvs();
  const bool has_normals = mesh.normal_triangles.size() == mesh.triangles.size();
  std::vector<Triangle> triangles, uv_triangles, normal_triangles;
  std::vector<int> surface;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle corners = mesh.triangles[t];
    std::array<bool, 3> split{};
    std::array<Vec3, 3> p;
    std::array<int, 6> position{}, uv{}, normal{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      split[k] = is_split.contains(edge_key(corners[k], corners[next]));
      p[k] = mesh.positions[corners[k]];
      position[k] = corners[k];
      if (split[k]) position[k + 3] = mid_position(corners[k], corners[next]);
      if (has_uvs) {
        const Triangle& f = mesh.uv_triangles[t];
        uv[k] = f[k];
        if (split[k]) uv[k + 3] = mid_uv(f[k], f[next]);
      }
      if (has_normals) {
        const Triangle& f = mesh.normal_triangles[t];
        normal[k] = f[k];
        if (split[k]) normal[k + 3] = mid_normal(f[k], f[next], true);
      }
    }
    const auto pick = [](const std::array<int, 6>& index, const Triangle& f) -> Triangle {
      return {index[f[0]], index[f[1]], index[f[2]]};
    };
    for (const Triangle& f : pattern_of(split, p)) {
      triangles.push_back(pick(position, f));
      surface.push_back(mesh.triangle_surface[t]);
      if (has_uvs) uv_triangles.push_back(pick(uv, f));
      if (has_normals) normal_triangles.push_back(pick(normal, f));
    }
  }
  mid_position.list_ends(parents);
  mid_position.move_by([&bulges](int a, int b) { return bulges.of(a, b); });
  mesh.triangles = std::move(triangles);
  mesh.uv_triangles = std::move(uv_triangles);
  mesh.normal_triangles = std::move(normal_triangles);
  mesh.triangle_surface = std::move(surface);
}

}  // namespace

Mesh refine_edges(Mesh mesh, double max_edge, int max_triangles, RefineShape shape,
                  std::vector<std::array<int, 2>>& parents) {
  if (!(max_edge > 0.0)) throw InvalidInput("max_edge: " + number_text(max_edge) + " is out of range; use > 0");
  if (shape == RefineShape::Curved) mesh = with_corner_normals(std::move(mesh));
  while (true) {
    std::int64_t budget = std::int64_t{max_triangles} - mesh.num_triangles();
    const std::vector<LongEdge> edges = find_long_edges(mesh, max_edge);
    std::unordered_set<std::uint64_t> chosen;
    chosen.reserve(edges.size());
    for (const LongEdge& edge : edges) {
      if (edge.num_triangles > budget) break;
      budget -= edge.num_triangles;
      chosen.insert(edge.key);
    }
    if (chosen.empty()) return mesh;
    split_edges(mesh, chosen, shape, parents);
  }
}

Mesh refine_edges(Mesh mesh, double max_edge, int max_triangles, RefineShape shape) {
  std::vector<std::array<int, 2>> parents;
  return refine_edges(std::move(mesh), max_edge, max_triangles, shape, parents);
}

}  // namespace patinate
