#include "tests/libcommon/geometry/shapes.h"

#include <cmath>

namespace patinate::testing_support {

namespace {

void finish(Mesh& mesh) {
  mesh.surfaces = {{"shape", ""}};
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
}

}  // namespace

Mesh make_icosphere(double radius, int levels) {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  Mesh mesh;
  mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  finish(mesh);
  const auto project = [&] {
    for (Vec3& p : mesh.positions) p *= radius / p.norm();
  };
  project();
  for (int i = 0; i < levels; ++i) {
    mesh = refine_edges(mesh, radius * 1.2 * std::pow(0.5, i + 1) * 0.6, mesh.num_triangles() * 4);
    project();
  }
  return mesh;
}

Mesh make_patch(int nu, int nv, const std::function<Vec3(double, double)>& point) {
  Mesh mesh;
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) {
      const Vec2 uv(static_cast<double>(i) / nu, static_cast<double>(j) / nv);
      mesh.uvs.push_back(uv);
      mesh.positions.push_back(point(uv.x(), uv.y()));
    }
  }
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      const int a = j * (nu + 1) + i, b = a + 1, c = a + nu + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  mesh.uv_triangles = mesh.triangles;
  finish(mesh);
  return mesh;
}

Mesh make_cube(double size) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.push_back(size * Vec3(i & 1, (i >> 1) & 1, (i >> 2) & 1));
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  finish(mesh);
  return mesh;
}

}  // namespace patinate::testing_support
