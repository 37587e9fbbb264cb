#include "libcommon/geometry/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "libcommon/core/error.h"
#include "libcommon/core/text.h"

namespace patinate {

namespace {

const Vec3& corner(const Mesh& mesh, const Triangle& triangle, std::size_t k) {
  return mesh.positions[static_cast<std::size_t>(triangle[k])];
}

/// Keeps the entries of `values` that `triangles` use, in their old order.
template <class T>
void keep_used(std::vector<T>& values, std::vector<Triangle>& triangles) {
  std::vector<int> new_index(values.size(), -1);
  for (const Triangle& t : triangles) {
    for (int i : t) new_index[static_cast<std::size_t>(i)] = 0;
  }
  std::size_t num_kept = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (new_index[i] < 0) continue;
    new_index[i] = static_cast<int>(num_kept);
    values[num_kept++] = values[i];
  }
  values.resize(num_kept);
  for (Triangle& t : triangles) {
    for (int& i : t) i = new_index[static_cast<std::size_t>(i)];
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

}  // namespace

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
  const Triangle& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  return (corner(mesh, t, 1) - corner(mesh, t, 0)).cross(corner(mesh, t, 2) - corner(mesh, t, 0));
}

std::vector<Vec3> vertex_normals(const Mesh& mesh) {
  std::vector<Vec3> normals(mesh.positions.size(), Vec3::Zero());
  for (int i = 0; i < mesh.num_triangles(); ++i) {
    const Vec3 area = area_vector(mesh, i);
    const double length = area.norm();
    if (!(length > 0.0)) continue;
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 a = corner(mesh, t, (k + 1) % 3) - corner(mesh, t, k);
      const Vec3 b = corner(mesh, t, (k + 2) % 3) - corner(mesh, t, k);
      const double angle = std::atan2(length, a.dot(b));
      normals[static_cast<std::size_t>(t[k])] += angle / length * area;
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
  const bool has_uvs = mesh.has_uvs();
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
  struct Side {
    std::uint64_t edge;
    int triangle;
    int k;
  };
  std::vector<Side> sides;
  sides.reserve(mesh.triangles.size() * 3);
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const Triangle& corners = mesh.triangles[static_cast<std::size_t>(t)];
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] =
          std::minmax(corners[static_cast<std::size_t>(k)], corners[static_cast<std::size_t>((k + 1) % 3)]);
      sides.push_back({static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high), t, k});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge < b.edge; });
  std::vector<std::array<int, 3>> neighbors(mesh.triangles.size(), {-1, -1, -1});
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].edge == sides[i].edge) ++end;
    if (end - i == 2) {
      neighbors[static_cast<std::size_t>(sides[i].triangle)][static_cast<std::size_t>(sides[i].k)] =
          sides[i + 1].triangle;
      neighbors[static_cast<std::size_t>(sides[i + 1].triangle)][static_cast<std::size_t>(sides[i + 1].k)] =
          sides[i].triangle;
    }
    i = end;
  }
  return neighbors;
}

}  // namespace patinate
