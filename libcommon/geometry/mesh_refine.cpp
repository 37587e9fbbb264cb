#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>

#include "libcommon/core/error.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh.h"

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
      const double squared = (mesh.positions[static_cast<std::size_t>(std::max(a, b))] -
                              mesh.positions[static_cast<std::size_t>(std::min(a, b))])
                                 .squaredNorm();
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
  explicit Midpoints(std::vector<Vector>& values) : values_(values) {}
  int operator()(int a, int b, bool normalize = false) {
    if (a == b) return a;
    const auto [entry, is_new] = made_.try_emplace(edge_key(a, b), static_cast<int>(values_.size()));
    if (is_new) {
      const Vector low = values_[static_cast<std::size_t>(std::min(a, b))];
      const Vector high = values_[static_cast<std::size_t>(std::max(a, b))];
      Vector mid = 0.5 * (low + high);
      if (normalize) mid = mid.norm() > 1e-9 ? Vector(mid / mid.norm()) : low;
      values_.push_back(mid);
    }
    return entry->second;
  }

 private:
  std::vector<Vector>& values_;
  std::unordered_map<std::uint64_t, int> made_;
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
  while (count == 1 ? !is_split[static_cast<std::size_t>(r)] : is_split[static_cast<std::size_t>((r + 2) % 3)]) ++r;
  const auto c = [r](int k) { return (k + r) % 3; };
  const auto m = [r](int k) { return 3 + (k + r) % 3; };
  if (count == 1) return {{c(0), m(0), c(2)}, {m(0), c(1), c(2)}};
  const auto at = [&](int k) -> const Vec3& { return p[static_cast<std::size_t>(c(k))]; };
  const double from_corner_0 = (0.5 * (at(1) + at(2)) - at(0)).squaredNorm();
  const double from_corner_2 = (0.5 * (at(0) + at(1)) - at(2)).squaredNorm();
  if (from_corner_0 <= from_corner_2) return {{m(0), c(1), m(1)}, {c(0), m(0), m(1)}, {c(0), m(1), c(2)}};
  return {{m(0), c(1), m(1)}, {c(0), m(0), c(2)}, {m(0), m(1), c(2)}};
}

/// One pass: splits the given edges wherever they occur.
void split_edges(Mesh& mesh, const std::unordered_set<std::uint64_t>& is_split) {
  Midpoints<Vec3> mid_position(mesh.positions);
  Midpoints<Vec2> mid_uv(mesh.uvs);
  Midpoints<Vec3> mid_normal(mesh.normals);
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
      p[k] = mesh.positions[static_cast<std::size_t>(corners[k])];
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
      return {index[static_cast<std::size_t>(f[0])], index[static_cast<std::size_t>(f[1])],
              index[static_cast<std::size_t>(f[2])]};
    };
    for (const Triangle& f : pattern_of(split, p)) {
      triangles.push_back(pick(position, f));
      surface.push_back(mesh.triangle_surface[t]);
      if (has_uvs) uv_triangles.push_back(pick(uv, f));
      if (has_normals) normal_triangles.push_back(pick(normal, f));
    }
  }
  mesh.triangles = std::move(triangles);
  mesh.uv_triangles = std::move(uv_triangles);
  mesh.normal_triangles = std::move(normal_triangles);
  mesh.triangle_surface = std::move(surface);
}

}  // namespace

Mesh refine_edges(Mesh mesh, double max_edge, int max_triangles) {
  if (!(max_edge > 0.0)) throw InvalidInput("max_edge: " + number_text(max_edge) + " is out of range; use > 0");
  while (true) {
    std::int64_t budget = std::int64_t{max_triangles} - mesh.num_triangles();
    std::unordered_set<std::uint64_t> chosen;
    for (const LongEdge& edge : find_long_edges(mesh, max_edge)) {
      if (edge.num_triangles > budget) break;
      budget -= edge.num_triangles;
      chosen.insert(edge.key);
    }
    if (chosen.empty()) return mesh;
    split_edges(mesh, chosen);
  }
}

}  // namespace patinate
