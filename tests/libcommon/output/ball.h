/// \file
/// Small textured meshes.
#pragma once

#include <cmath>
#include <numbers>

#include "patinate/geometry/mesh.h"

namespace patinate::testing_support {

/// Latitude-longitude sphere around the origin, y up, with UVs and exact normals; 2 n x n quads.
inline Mesh ball(double radius, int n) {
  Mesh mesh;
  mesh.surfaces = {{"ball", ""}};
  const double pi = std::numbers::pi;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= 2 * n; ++i) {
      const double a = pi * i / n, e = pi * j / n - 0.5 * pi;
      const Vec3 d(std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a));
      mesh.positions.push_back(radius * d);
      mesh.normals.push_back(d);
      mesh.uvs.push_back({0.5 * i / n, static_cast<double>(j) / n});
    }
  }
  const auto add = [&](int a, int b, int c) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangle_surface.push_back(0);
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < 2 * n; ++i) {
      const int a = j * (2 * n + 1) + i, b = a + 1, c = a + 2 * n + 1, d = c + 1;
      if (j > 0) add(a, b, d);
      if (j < n - 1) add(a, d, c);
    }
  }
  mesh.uv_triangles = mesh.normal_triangles = mesh.triangles;
  return mesh;
}

/// Square plate of a side length at a height, facing up (y); u along x, v along -z; 8 x 8 quads.
inline Mesh plate(double side, double height) {
  constexpr int kQuads = 8;
  Mesh mesh;
  mesh.surfaces = {{"plate", ""}};
  for (int j = 0; j <= kQuads; ++j) {
    for (int i = 0; i <= kQuads; ++i) {
      const double u = static_cast<double>(i) / kQuads, v = static_cast<double>(j) / kQuads;
      mesh.positions.push_back({side * (u - 0.5), height, -side * (v - 0.5)});
      mesh.uvs.push_back({u, v});
    }
  }
  for (int j = 0; j < kQuads; ++j) {
    for (int i = 0; i < kQuads; ++i) {
      const int a = j * (kQuads + 1) + i, b = a + 1, c = a + kQuads + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
      mesh.triangle_surface.insert(mesh.triangle_surface.end(), 2, 0);
    }
  }
  mesh.uv_triangles = mesh.triangles;
  return mesh;
}

}  // namespace patinate::testing_support
