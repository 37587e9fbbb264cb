#include "libcommon/geometry/mesh_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr double kLeastSine = 1e-12;
constexpr std::size_t kMaxDifferent = 16;

std::string counted(int count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

bool has_area(const Mesh& mesh, int triangle) {
  const Triangle& t = mesh.triangles[triangle];
  double longest = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    longest = std::max(longest, (mesh.positions[t[(k + 1) % 3]] - mesh.positions[t[k]]).squaredNorm());
  }
  return area_vector(mesh, triangle).norm() > kLeastSine * longest;
}

/// A triangle by its positions in rising order, with the UV of each.
struct Identity {
  std::array<int, 3> positions;
  std::array<Vec2, 3> uvs;
  int surface;
};

Identity identity_of(const Mesh& mesh, int triangle) {
  const auto t = static_cast<std::size_t>(triangle);
  std::array<std::size_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return mesh.triangles[t][a] < mesh.triangles[t][b]; });
  Identity identity{};
  for (std::size_t k = 0; k < 3; ++k) {
    identity.positions[k] = mesh.triangles[t][order[k]];
    const int uv = mesh.uv_triangles.empty() ? -1 : mesh.uv_triangles[t][order[k]];
    identity.uvs[k] = uv < 0 ? Vec2(0.0, 0.0) : mesh.uvs[uv];
  }
  identity.surface = mesh.triangle_surface.empty() ? 0 : mesh.triangle_surface[t];
  return identity;
}

/// is_kept[t] = 0 for every triangle that an earlier one equals.
void leave_out_duplicates(const Mesh& mesh, std::vector<char>& is_kept, MeshRepairs& repairs) {
  std::vector<std::pair<std::array<int, 3>, int>> sorted;
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    if (is_kept[t] != 0) sorted.emplace_back(identity_of(mesh, t).positions, t);
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0, end = 0; i < sorted.size(); i = end) {
    while (end < sorted.size() && sorted[end].first == sorted[i].first) ++end;
    std::vector<Identity> different;  // Triangles at these three positions; the search among them is bounded.
    for (std::size_t k = i; k < end && end - i > 1; ++k) {
      const Identity found = identity_of(mesh, sorted[k].second);
      const bool is_new = std::none_of(different.begin(), different.end(), [&](const Identity& d) {
        return d.uvs == found.uvs && d.surface == found.surface;
      });
      if (is_new && different.size() < kMaxDifferent) different.push_back(found);
      if (is_new) continue;
      is_kept[sorted[k].second] = 0;
      ++repairs.num_duplicates;
    }
  }
}

void turn(Mesh& mesh, std::size_t t) {
  std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  if (!mesh.uv_triangles.empty()) std::swap(mesh.uv_triangles[t][1], mesh.uv_triangles[t][2]);
  if (mesh.normal_triangles.size() != mesh.triangles.size()) return;
  std::swap(mesh.normal_triangles[t][1], mesh.normal_triangles[t][2]);
  const Vec3 area = area_vector(mesh, static_cast<int>(t));
  for (int& n : mesh.normal_triangles[t]) {
    const Vec3 normal = mesh.normals[n];
    if (!(normal.dot(area) < 0.0)) continue;
    n = static_cast<int>(mesh.normals.size());
    mesh.normals.emplace_back(-normal);
  }
}

/// Whether both triangles run the same way along their shared edge.
bool disagree(const Mesh& mesh, std::size_t t, std::size_t k, std::size_t neighbor) {
  const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
  const Triangle& n = mesh.triangles[neighbor];
  for (std::size_t i = 0; i < 3; ++i) {
    if (n[i] == a && n[(i + 1) % 3] == b) return true;
  }
  return false;
}

/// Turns the smaller part, by area, of every piece whose triangles disagree.
void agree_on_sides(Mesh& mesh, MeshRepairs& repairs) {
  const std::vector<std::array<int, 3>> neighbors = triangle_neighbors(mesh);
  std::vector<char> side(mesh.triangles.size(), -1);
  std::vector<std::size_t> piece;
  for (std::size_t seed = 0; seed < side.size(); ++seed) {
    if (side[seed] >= 0) continue;
    side[seed] = 0;
    piece.assign(1, seed);
    std::array<double, 2> area{0.0, 0.0};
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const std::size_t t = piece[i];
      area[side[t] == 0 ? 0 : 1] += area_vector(mesh, static_cast<int>(t)).norm();
      for (std::size_t k = 0; k < 3; ++k) {
        if (neighbors[t][k] < 0) continue;
        const auto n = static_cast<std::size_t>(neighbors[t][k]);
        if (side[n] >= 0) continue;
        side[n] = static_cast<char>(disagree(mesh, t, k, n) ? 1 - side[t] : side[t]);
        piece.push_back(n);
      }
    }
    const char turned = area[1] > area[0] ? 0 : 1;
    for (std::size_t t : piece) {
      if (side[t] != turned) continue;
      turn(mesh, t);
      ++repairs.num_turned;
    }
  }
}

int count_complex_edges(const Mesh& mesh) {
  std::vector<std::uint64_t> edges;
  edges.reserve(mesh.triangles.size() * 3);
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      edges.push_back(static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high));
    }
  }
  std::sort(edges.begin(), edges.end());
  int count = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    count += end - i > 2;
    i = end;
  }
  return count;
}

template <class T>
void keep(std::vector<T>& values, const std::vector<char>& is_kept) {
  if (values.size() != is_kept.size()) return;
  std::size_t num = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (is_kept[i] != 0) values[num++] = values[i];
  }
  values.resize(num);
}

}  // namespace

std::string MeshRepairs::text() const {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (num_degenerate > 0) add(counted(num_degenerate, "triangle") + " without area excluded");
  if (num_duplicates > 0)
    add(counted(num_duplicates, "triangle") +
        (num_duplicates == 1 ? " that repeats another excluded" : " that repeat others excluded"));
  if (num_turned > 0)
    add(counted(num_turned, "triangle") +
        (num_turned == 1 ? " turned to face as its neighbors do" : " turned to face as their neighbors do"));
  if (num_complex_edges > 0)
    add(counted(num_complex_edges, "edge") + (num_complex_edges == 1 ? " has" : " have") + " more than two triangles");
  return text;
}

RepairedMesh repair_mesh(Mesh mesh) {
  MeshRepairs repairs;
  std::vector<char> is_kept(mesh.triangles.size(), 1);
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    if (has_area(mesh, t)) continue;
    is_kept[t] = 0;
    ++repairs.num_degenerate;
  }
  leave_out_duplicates(mesh, is_kept, repairs);
  if (repairs.num_degenerate == mesh.num_triangles())
    throw InvalidInput("no triangle has an area; a surface is needed");
  if (repairs.num_degenerate + repairs.num_duplicates > 0) {
    keep(mesh.uv_triangles, is_kept);
    keep(mesh.normal_triangles, is_kept);
    keep(mesh.triangle_surface, is_kept);
    keep(mesh.triangles, is_kept);
    mesh = select_surfaces(mesh, "", "");  // Without what only they used.
  }
  agree_on_sides(mesh, repairs);
  repairs.num_complex_edges = count_complex_edges(mesh);
  return {std::move(mesh), repairs};
}

}  // namespace patinate
