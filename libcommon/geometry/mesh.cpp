#include "patinate/geometry/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

const Vec3& corner(const Mesh& mesh, const Triangle& triangle, std::size_t k) { return mesh.positions[triangle[k]]; }

/// Keeps the entries of `values` that `triangles` use, in their old order.
template <class T>
void keep_used(std::vector<T>& values, std::vector<Triangle>& triangles) {
  std::vector<int> new_index(values.size(), -1);
  for (const Triangle& t : triangles) {
    for (int i : t) {
      if (i >= 0) new_index[i] = 0;
    }
  }
  std::size_t num_kept = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (new_index[i] < 0) continue;
    new_index[i] = static_cast<int>(num_kept);
    values[num_kept++] = values[i];
  }
  values.resize(num_kept);
  for (Triangle& t : triangles) {
    for (int& i : t) {
      if (i >= 0) i = new_index[i];
    }
  }
}

/// "`a`, `b`" without repetition, in order of first use.
std::string name_list(const std::vector<Mesh::Surface>& surfaces, std::string Mesh::Surface::*field) {
  std::vector<std::string> names;
  for (const Mesh::Surface& s : surfaces) {
    if (std::find(names.begin(), names.end(), s.*field) == names.end()) names.push_back(s.*field);
  }
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "`" : ", `") + name + "`";
  return text;
}

[[noreturn]] void fail_selection(const Mesh& mesh, const std::string& node, const std::string& material) {
  std::string wanted;
  if (!node.empty()) wanted = "node `" + node + "`";
  if (!material.empty()) wanted += (wanted.empty() ? "material `" : " with material `") + material + "`";
  if (wanted.empty()) throw InvalidInput("the mesh has no triangles");
  throw InvalidInput("no surface has " + wanted + "; nodes: " + name_list(mesh.surfaces, &Mesh::Surface::node) +
                     "; materials: " + name_list(mesh.surfaces, &Mesh::Surface::material));
}

/// A triangle's side along an edge.
struct Side {
  std::uint64_t edge;
  int triangle;
  int k;
};

constexpr std::size_t kMaxSidesToPair = 64;  ///< Pairs are tried in quadratic time.

/// Pairs of sides of one edge that run in opposite directions, the least bent first.
std::vector<std::pair<Side, Side>> smoothest_pairs(const Mesh& mesh, std::span<const Side> sides) {
  struct Pair {
    double cosine;
    std::size_t a, b;
  };
  const auto first = [&](const Side& s) { return mesh.triangles[s.triangle][s.k]; };
  std::vector<Pair> candidates;
  for (std::size_t a = 0; a < sides.size(); ++a) {
    for (std::size_t b = a + 1; b < sides.size(); ++b) {
      if (first(sides[a]) == first(sides[b])) continue;
      const Vec3 na = area_vector(mesh, sides[a].triangle), nb = area_vector(mesh, sides[b].triangle);
      const double length = na.norm() * nb.norm();
      candidates.push_back({length > 0.0 ? na.dot(nb) / length : -1.0, a, b});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Pair& x, const Pair& y) { return x.cosine > y.cosine; });
  std::vector<char> is_taken(sides.size(), 0);
  std::vector<std::pair<Side, Side>> pairs;
  for (const Pair& c : candidates) {
    if (is_taken[c.a] || is_taken[c.b]) continue;
    is_taken[c.a] = is_taken[c.b] = 1;
    pairs.emplace_back(sides[c.a], sides[c.b]);
  }
  return pairs;
}

}  // namespace

int Mesh::num_triangles_with_uvs() const {
  if (uv_triangles.size() != triangles.size()) return 0;
  return static_cast<int>(std::count_if(uv_triangles.begin(), uv_triangles.end(),
                                        [](const Triangle& t) { return t[0] >= 0 && t[1] >= 0 && t[2] >= 0; }));
}

Box bounding_box(const Mesh& mesh) {
  Box box;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      box.low = box.low.cwiseMin(corner(mesh, t, k));
      box.high = box.high.cwiseMax(corner(mesh, t, k));
    }
  }
  return box;
}

Vec3 area_vector(const Mesh& mesh, int triangle) {
  const Triangle& t = mesh.triangles[triangle];
  return (corner(mesh, t, 1) - corner(mesh, t, 0)).cross(corner(mesh, t, 2) - corner(mesh, t, 0));
}

std::vector<Vec3> vertex_normals(const Mesh& mesh) {
  std::vector<Vec3> normals(mesh.positions.size(), Vec3::Zero());
  for (int i = 0; i < mesh.num_triangles(); ++i) {
    const Vec3 area = area_vector(mesh, i);
    const double length = area.norm();
    if (!(length > 0.0)) continue;
    const Triangle& t = mesh.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 a = corner(mesh, t, (k + 1) % 3) - corner(mesh, t, k);
      const Vec3 b = corner(mesh, t, (k + 2) % 3) - corner(mesh, t, k);
      const double angle = std::atan2(length, a.dot(b));
      normals[t[k]] += angle / length * area;
    }
  }
  for (Vec3& n : normals) {
    const double length = n.norm();
    n = length > 1e-12 ? Vec3(n / length) : Vec3(Vec3::UnitZ());
  }
  return normals;
}

Mesh with_normals(Mesh mesh) {
  if (!mesh.triangles.empty() && mesh.normal_triangles.size() == mesh.triangles.size()) return mesh;
  mesh.normals = vertex_normals(mesh);
  mesh.normal_triangles = mesh.triangles;
  return mesh;
}

void scale_mesh(Mesh& mesh, double factor) {
  for (Vec3& p : mesh.positions) p *= factor;
}

Mesh select_surfaces(const Mesh& mesh, const std::string& node, const std::string& material) {
  std::vector<int> new_surface(mesh.surfaces.size(), -1);
  const bool has_uvs = mesh.uv_triangles.size() == mesh.triangles.size();
  const bool has_normals = mesh.normal_triangles.size() == mesh.triangles.size();
  Mesh out;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto old = static_cast<std::size_t>(mesh.triangle_surface[t]);
    const Mesh::Surface& surface = mesh.surfaces[old];
    if ((!node.empty() && surface.node != node) || (!material.empty() && surface.material != material)) continue;
    if (new_surface[old] < 0) {
      new_surface[old] = static_cast<int>(out.surfaces.size());
      out.surfaces.push_back(surface);
    }
    out.triangles.push_back(mesh.triangles[t]);
    out.triangle_surface.push_back(new_surface[old]);
    if (has_uvs) out.uv_triangles.push_back(mesh.uv_triangles[t]);
    if (has_normals) out.normal_triangles.push_back(mesh.normal_triangles[t]);
  }
  if (out.triangles.empty()) fail_selection(mesh, node, material);
  out.positions = mesh.positions;
  keep_used(out.positions, out.triangles);
  if (has_uvs) {
    out.uvs = mesh.uvs;
    keep_used(out.uvs, out.uv_triangles);
  }
  if (has_normals) {
    out.normals = mesh.normals;
    keep_used(out.normals, out.normal_triangles);
  }
  return out;
}

std::vector<std::array<int, 3>> triangle_neighbors(const Mesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(mesh.triangles.size() * 3);
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(corners[k], corners[(k + 1) % 3]);
      sides.push_back({static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high), t, k});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge < b.edge; });
  std::vector<std::array<int, 3>> neighbors(mesh.triangles.size(), {-1, -1, -1});
  const auto join = [&neighbors](const Side& a, const Side& b) {
    neighbors[a.triangle][a.k] = b.triangle;
    neighbors[b.triangle][b.k] = a.triangle;
  };
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].edge == sides[i].edge) ++end;
    if (end - i == 2) {
      join(sides[i], sides[i + 1]);
    } else if (end - i > 2 && end - i <= kMaxSidesToPair) {
      for (const auto& [a, b] : smoothest_pairs(mesh, std::span(sides).subspan(i, end - i))) join(a, b);
    }
    i = end;
  }
  return neighbors;
}

}  // namespace patinate
