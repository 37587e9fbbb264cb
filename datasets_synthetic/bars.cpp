#include "datasets_synthetic/bars.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace patinate::datasets {

namespace {

constexpr double kBarGutter = 3.0 / 1024.0;

/// A face in its own plane, mm, turned by its angle.
class Plane {
 public:
  explicit Plane(const Face& face) : origin_(face.corners[0]) {
    const auto& c = face.corners;
    const Vec3 along = (c[1] - c[0]).normalized(), normal = along.cross(c[2] - c[0]).normalized(),
               across = normal.cross(along);
    normal_ = normal;
    x_ = std::cos(face.angle) * along + std::sin(face.angle) * across;
    y_ = normal.cross(x_);
    low_ = high_ = at(c[0]);
    for (const Vec3& corner : c) {
      low_ = low_.cwiseMin(at(corner));
      high_ = high_.cwiseMax(at(corner));
    }
  }
  [[nodiscard]] const Vec3& normal() const { return normal_; }
  [[nodiscard]] Vec2 size() const { return high_ - low_; }
  /// From the lower left corner of what it takes up.
  [[nodiscard]] Vec2 local(const Vec3& p) const { return at(p) - low_; }

 private:
  [[nodiscard]] Vec2 at(const Vec3& p) const { return {(p - origin_).dot(x_), (p - origin_).dot(y_)}; }
  Vec3 origin_, x_, y_, normal_;
  Vec2 low_, high_;
};

/// Point of a face's surface, at shares of its sides.
Vec3 point_at(const Face& face, double a, double b) {
  const auto& c = face.corners;
  return (1 - b) * ((1 - a) * c[0] + a * c[1]) + b * ((1 - a) * c[3] + a * c[2]);
}

/// Lower left corners (u, v) of sizes in rows, in an order, at `scale` UV a mm; empty when they do not fit.
std::vector<Vec2> place(const std::vector<Vec2>& sizes, const std::vector<std::size_t>& order, double scale) {
  std::vector<Vec2> corners(sizes.size());
  double x = kBarGutter, y = kBarGutter, row = 0.0;
  for (const std::size_t i : order) {
    const Vec2 size = sizes[i] * scale;
    if (x + size.x() + kBarGutter > 1.0) {
      x = kBarGutter;
      y += row + kBarGutter;
      row = 0.0;
    }
    if (x + size.x() + kBarGutter > 1.0 || y + size.y() + kBarGutter > 1.0) return {};
    corners[i] = {x, y};
    x += size.x() + kBarGutter;
    row = std::max(row, size.y());
  }
  return corners;
}

void add_face(Mesh& mesh, const Face& face, const Plane& plane, const Vec2& corner, double scale) {
  const int nx = face.cells_x, ny = face.cells_y;
  const int first = static_cast<int>(mesh.positions.size());
  for (int j = 0; j <= ny; ++j) {
    for (int i = 0; i <= nx; ++i) {
      const Vec3 p = point_at(face, static_cast<double>(i) / nx, static_cast<double>(j) / ny);
      mesh.positions.push_back(p);
      mesh.uvs.push_back(corner + plane.local(p) * scale);
    }
  }
  const int normal = static_cast<int>(mesh.normals.size());
  mesh.normals.push_back(plane.normal());
  const auto add = [&](int i0, int i1, int i2) {
    mesh.triangles.push_back({first + i0, first + i1, first + i2});
    mesh.normal_triangles.push_back({normal, normal, normal});
  };
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const int a = j * (nx + 1) + i;
      add(a, a + 1, a + nx + 2);
      add(a, a + nx + 2, a + nx + 1);
    }
  }
}

/// Equal positions become one, so that surfaces are connected over the edges of a box.
void merge_positions(Mesh& mesh) {
  mesh.uv_triangles = mesh.triangles;
  std::vector<std::size_t> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&](std::size_t i) {
    const Vec3& p = mesh.positions[i];
    return std::array<std::int64_t, 3>{std::llround(p.x() * 1e4), std::llround(p.y() * 1e4), std::llround(p.z() * 1e4)};
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  std::vector<int> target(order.size());
  std::vector<Vec3> merged;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k == 0 || key(order[k]) != key(order[k - 1])) merged.push_back(mesh.positions[order[k]]);
    target[order[k]] = static_cast<int>(merged.size()) - 1;
  }
  for (Triangle& t : mesh.triangles) {
    for (int& corner : t) corner = target[corner];
  }
  mesh.positions = std::move(merged);
}

}  // namespace

void add_bar(std::vector<Face>& faces, double x0, double x1, const std::array<Vec2, 4>& section_yz, double cell_mm) {
  const auto cells = [&](double length) { return std::max(1, static_cast<int>(std::lround(length / cell_mm))); };
  const int along = cells(x1 - x0), deep = cells((section_yz[1] - section_yz[0]).norm()),
            high = cells((section_yz[2] - section_yz[1]).norm());
  const auto at = [&](double x, std::size_t k) { return Vec3(x, section_yz[k].x(), section_yz[k].y()); };
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t n = (k + 1) % 4;
    faces.push_back({{at(x0, n), at(x1, n), at(x1, k), at(x0, k)}, along, k % 2 == 0 ? deep : high});
  }
  faces.push_back({{at(x1, 0), at(x1, 1), at(x1, 2), at(x1, 3)}, deep, high});
  faces.push_back({{at(x0, 1), at(x0, 0), at(x0, 3), at(x0, 2)}, deep, high});
}

std::vector<Face> in_patches(const std::vector<Face>& faces, int num_charts) {
  if (num_charts <= 1) return faces;
  std::vector<Face> patches;
  for (const Face& face : faces) {
    const double longer = std::max(face.cells_x, face.cells_y);
    const auto count = [&](int cells) {
      return std::clamp(static_cast<int>(std::lround(num_charts * cells / longer)), 1, cells);
    };
    const int nx = count(face.cells_x), ny = count(face.cells_y);
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        const int x0 = face.cells_x * i / nx, x1 = face.cells_x * (i + 1) / nx, y0 = face.cells_y * j / ny,
                  y1 = face.cells_y * (j + 1) / ny;
        const auto at = [&](int x, int y) {
          return point_at(face, static_cast<double>(x) / face.cells_x, static_cast<double>(y) / face.cells_y);
        };
        const double angle = 0.4 + 2.4 * static_cast<double>(patches.size());  // no two neighbors alike
        patches.push_back({{at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1)}, x1 - x0, y1 - y0, angle});
      }
    }
  }
  return patches;
}

Mesh mesh_of_faces(const std::vector<Face>& faces, double largest_mm, const std::string& node,
                   const std::string& material) {
  std::vector<Plane> planes;
  std::vector<Vec2> sizes;
  for (const Face& face : faces) {
    planes.emplace_back(face);
    sizes.push_back(planes.back().size());
  }
  std::vector<std::size_t> order(faces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sizes[a].y() > sizes[b].y(); });
  double scale = 1.0 / largest_mm;
  std::vector<Vec2> corners = place(sizes, order, scale);
  while (corners.empty()) corners = place(sizes, order, scale *= 0.995);
  Mesh mesh;
  for (std::size_t i = 0; i < faces.size(); ++i) add_face(mesh, faces[i], planes[i], corners[i], scale);
  merge_positions(mesh);
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  mesh.surfaces.push_back({.node = node, .material = material});
  return mesh;
}

}  // namespace patinate::datasets
