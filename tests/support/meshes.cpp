#include "tests/support/meshes.h"

#include <cmath>
#include <functional>

namespace patinate::testing_support {

namespace {

/// n x n cells over [0, side]^2; `uv` gives the UV of a corner of cell column `cell`.
Mesh grid(double side_mm, int n, const std::function<Vec2(double x, double y, int cell)>& uv) {
  Mesh mesh;
  mesh.surfaces.push_back({"plane", "plane"});
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) mesh.positions.emplace_back(side_mm * i / n, side_mm * j / n, 0.0);
  }
  const auto add = [&](int cell, const std::array<std::array<int, 2>, 3>& corners) {
    Triangle positions{}, uvs{};
    for (std::size_t k = 0; k < 3; ++k) {
      positions[k] = corners[k][1] * (n + 1) + corners[k][0];
      uvs[k] = static_cast<int>(mesh.uvs.size());
      mesh.uvs.push_back(uv(static_cast<double>(corners[k][0]) / n, static_cast<double>(corners[k][1]) / n, cell));
    }
    mesh.triangles.push_back(positions);
    mesh.uv_triangles.push_back(uvs);
    mesh.triangle_surface.push_back(0);
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      add(i, {{{i, j}, {i + 1, j}, {i + 1, j + 1}}});
      add(i, {{{i, j}, {i + 1, j + 1}, {i, j + 1}}});
    }
  }
  return mesh;
}

}  // namespace

Mesh unit_plane(double side_mm, int n) {
  return grid(side_mm, n, [](double x, double y, int) { return Vec2(x, y); });
}

Mesh cut_plane(double side_mm, int n) {
  return grid(side_mm, n, [n](double x, double y, int cell) {
    constexpr double kDensity = 0.5;  // UV per side; the left half takes 0.25 x 0.5, the right one 0.5 x 0.25.
    if (cell < n / 2) return Vec2(0.1 + kDensity * x, 0.1 + kDensity * y);
    return Vec2(0.45 + kDensity * y, 0.9 - kDensity * (x - 0.5));
  });
}

namespace {

/// Charts that are turned; `shape(i, j)` scales their u and v.
template <class Shape>
Mesh turned_cells(double side_mm, int n, Shape&& shape) {
  Mesh mesh = unit_plane(side_mm, n);
  mesh.uvs.clear();
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const double angle = 0.4 + 2.4 * (i + n * j);  // no two neighbors alike
      const double half = 0.45 / std::sqrt(2.0) / n;
      const Vec2 scale = shape(i, j);
      const auto corner = [&](double x_corner, double y_corner) {
        const double x = scale.x() * x_corner, y = scale.y() * y_corner;
        return Vec2((i + 0.5) / n + half * (x * std::cos(angle) - y * std::sin(angle)),
                    (j + 0.5) / n + half * (x * std::sin(angle) + y * std::cos(angle)));
      };
      const int first = static_cast<int>(mesh.uvs.size());
      mesh.uvs.insert(mesh.uvs.end(), {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)});
      const auto cell = static_cast<std::size_t>(2 * (j * n + i));
      mesh.uv_triangles[cell] = {first, first + 1, first + 2};
      mesh.uv_triangles[cell + 1] = {first, first + 2, first + 3};
    }
  }
  return mesh;
}

}  // namespace

Mesh quilt_plane(double side_mm, int n) {
  return turned_cells(side_mm, n, [](int, int) { return Vec2(1.0, 1.0); });
}

Mesh patchwork_plane(double side_mm, int n) {
  return turned_cells(side_mm, n, [](int i, int j) {
    const double size = j % 2 == 0 ? 1.0 : 0.7;
    return Vec2((i + j) % 2 == 0 ? size : -size, size);
  });
}

Mesh udim_plane(double side_mm, int columns) {
  Mesh mesh = unit_plane(side_mm, 6 * columns);
  const Mesh plain = mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    double center = 0.0;
    for (int corner : plain.uv_triangles[t]) center += plain.uvs[corner].x() / 3.0;
    const double tile = std::floor(center * columns);
    for (int& corner : mesh.uv_triangles[t]) {
      const Vec2 uv = plain.uvs[corner];
      corner = static_cast<int>(mesh.uvs.size());
      mesh.uvs.emplace_back(tile + (uv.x() * columns - tile), uv.y());
    }
  }
  return mesh;
}

std::vector<Vec2> square_offsets(int radius, double step_mm) {
  std::vector<Vec2> offsets;
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      if (x != 0 || y != 0) offsets.emplace_back(x * step_mm, y * step_mm);
    }
  }
  return offsets;
}

}  // namespace patinate::testing_support
