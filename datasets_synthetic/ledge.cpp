#include "datasets_synthetic/ledge.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "libcommon/core/error.h"

namespace patinate {

namespace {

constexpr double kGutter = 3.0 / 1024.0;
constexpr double kInside = 0.04;    // of the wall's width: how far a sill enters the wall
constexpr double kFall = 0.08;      // slope of a sill's top
constexpr double kUnderside = 0.8;  // slope of its underside, back to the wall

/// A flat quadrangle, corners counter-clockwise seen from outside; the first side is at right angles to the second or fourth.
struct Face {
  std::array<Vec3, 4> corners;
  int cells_x = 1;  ///< Along the first side; faces that share an edge cut it alike.
  int cells_y = 1;
  [[nodiscard]] Vec3 along() const { return (corners[1] - corners[0]).normalized(); }
  [[nodiscard]] Vec3 normal() const { return (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized(); }
  /// In the face's plane, mm: from the first corner along the first side, and at right angles to it.
  [[nodiscard]] Vec2 local(const Vec3& p) const {
    const Vec3 d = p - corners[0];
    return {d.dot(along()), d.dot(normal().cross(along()))};
  }
  [[nodiscard]] Vec2 low() const {
    Vec2 v = local(corners[0]);
    for (const Vec3& c : corners) v = v.cwiseMin(local(c));
    return v;
  }
  [[nodiscard]] Vec2 size() const {
    Vec2 v = local(corners[0]);
    for (const Vec3& c : corners) v = v.cwiseMax(local(c));
    return v - low();
  }
  [[nodiscard]] double width() const { return size().x(); }
  [[nodiscard]] double height() const { return size().y(); }
};

/// A body between x0 and x1 whose section in the yz plane is a quadrangle, counter-clockwise seen from +x: front foot, back foot, back top,
/// front top.
void add_bar(std::vector<Face>& faces, double x0, double x1, const std::array<Vec2, 4>& section_yz, double cell_mm) {
  const auto cells = [&](double length) { return std::max(1, static_cast<int>(std::lround(length / cell_mm))); };
  const int along = cells(x1 - x0), deep = cells((section_yz[1] - section_yz[0]).norm()), high = cells((section_yz[2] - section_yz[1]).norm());
  const auto at = [&](double x, std::size_t k) { return Vec3(x, section_yz[k].x(), section_yz[k].y()); };
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t n = (k + 1) % 4;
    faces.push_back({{at(x0, n), at(x1, n), at(x1, k), at(x0, k)}, along, k % 2 == 0 ? deep : high});
  }
  faces.push_back({{at(x1, 0), at(x1, 1), at(x1, 2), at(x1, 3)}, deep, high});
  faces.push_back({{at(x0, 1), at(x0, 0), at(x0, 3), at(x0, 2)}, deep, high});
}

/// Lower left corners (u, v) of the faces in rows, tallest first, at `scale` UV a mm; empty when they do not fit.
std::vector<Vec2> place(const std::vector<Face>& faces, const std::vector<std::size_t>& order, double scale) {
  std::vector<Vec2> corners(faces.size());
  double x = kGutter, y = kGutter, row = 0.0;
  for (const std::size_t i : order) {
    const double w = faces[i].width() * scale, h = faces[i].height() * scale;
    if (x + w + kGutter > 1.0) {
      x = kGutter;
      y += row + kGutter;
      row = 0.0;
    }
    if (x + w + kGutter > 1.0 || y + h + kGutter > 1.0) return {};
    corners[i] = {x, y};
    x += w + kGutter;
    row = std::max(row, h);
  }
  return corners;
}

void add_face(Mesh& mesh, const Face& face, const Vec2& corner, double scale) {
  const auto& c = face.corners;
  const int nx = face.cells_x, ny = face.cells_y;
  const int first = static_cast<int>(mesh.positions.size());
  for (int j = 0; j <= ny; ++j) {
    for (int i = 0; i <= nx; ++i) {
      const double a = static_cast<double>(i) / nx, b = static_cast<double>(j) / ny;
      const Vec3 p = (1 - b) * ((1 - a) * c[0] + a * c[1]) + b * ((1 - a) * c[3] + a * c[2]);
      mesh.positions.push_back(p);
      mesh.uvs.push_back(corner + (face.local(p) - face.low()) * scale);
    }
  }
  const int normal = static_cast<int>(mesh.normals.size());
  mesh.normals.push_back(face.normal());
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
    for (int& corner : t) corner = target[static_cast<std::size_t>(corner)];
  }
  mesh.positions = std::move(merged);
}

}  // namespace

void describe(OptionVisitor& v, LedgeOptions& o) {
  v.visit({"width", "Width and height of the wall", "mm", above(0)}, o.width_mm);
  v.visit({"depth", "By how much the sills stand out; at most a fifth of the width", "mm", above(0)}, o.depth_mm);
  v.visit({"thickness", "Of a sill's front; at most a tenth of the width", "mm", above(0)}, o.thickness_mm);
  v.visit({"sills", "Sills, one above the other and beside each other in turn", "", between(1, 6)}, o.num_sills);
  v.visit({"cells", "Squares along the wall", "", between(1, 400)}, o.cells);
}

Mesh ledge(const LedgeOptions& options) {
  check_ranges(options);
  const double w = options.width_mm;
  if (options.thickness_mm > 0.1 * w) throw InvalidInput("a sill is thicker than a tenth of the wall's width");
  if (options.depth_mm > 0.2 * w) throw InvalidInput("a sill stands out by more than a fifth of the wall's width");
  std::vector<Face> faces;
  add_bar(faces, -0.5 * w, 0.5 * w, {Vec2(0, 0), Vec2(0, -0.1 * w), Vec2(w, -0.1 * w), Vec2(w, 0)}, w / options.cells);
  for (int i = 0; i < options.num_sills; ++i) {
    const double y = w * (0.84 - 0.6 * i / options.num_sills);
    const double middle = options.num_sills == 1 ? 0.0 : (i % 2 == 0 ? -0.2 : 0.22) * w;
    const double half = (0.24 - 0.02 * i) * w;
    const double d = options.depth_mm, back = -kInside * w, t = options.thickness_mm;
    // The underside falls back toward the wall, so that water creeps along it and down.
    add_bar(faces, middle - half, middle + half,
            {Vec2(y - kFall * d - t, d), Vec2(y - kFall * d - t - kUnderside * (d - back), back), Vec2(y - kFall * back, back), Vec2(y - kFall * d, d)}, w / options.cells);
  }
  std::vector<std::size_t> order(faces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return faces[a].height() > faces[b].height(); });
  double scale = 1.0 / w;
  std::vector<Vec2> corners = place(faces, order, scale);
  while (corners.empty()) corners = place(faces, order, scale *= 0.995);
  Mesh mesh;
  for (std::size_t i = 0; i < faces.size(); ++i) add_face(mesh, faces[i], corners[i], scale);
  merge_positions(mesh);
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  mesh.surfaces.push_back({.node = "wall", .material = "plaster"});
  return mesh;
}

std::string ledge_scene(const LedgeOptions& options, const std::string& mesh_file) {
  using Json = nlohmann::ordered_json;
  const double w = options.width_mm;
  Json json{{"format", "patinate.scene"}, {"version", 1}, {"unit", "mm"}, {"gravity", {0, -9810, 0}}, {"seed", 1}};
  json["atlas"] = {{"resolution", 1024}};
  json["materials"] = {"water", "dirt", "organic", "moss"};
  json["appearance"] = {{"dirt", {{"color", {0.05, 0.04, 0.03}}, {"strength", 1.6}}}};
  json["objects"] = Json::array({{{"name", "wall"}, {"mesh", mesh_file}, {"preset", "plaster"}}});
  // Dust settles on what looks up; slanting rain takes it over the edge, along the underside and down the wall.
  json["emitters"] = Json::array({{{"name", "rain"}, {"shape", "sky"}, {"direction", {0, -1, -0.12}}, {"spread_deg", 4}, {"speed", 3 * w}, {"gammatons", 2500}, {"carries", {{"water", 0.8}}}},
                                  {{"name", "dust"}, {"shape", "sky"}, {"direction", {0, -1, -0.02}}, {"spread_deg", 3}, {"speed", w}, {"gammatons", 2000}, {"carries", {{"dirt", 1.5}}}}});
  json["behaviour"] = {{"bounce", 0.02}, {"float", 0.965}, {"absorb", 0.015}, {"deceleration_bounce", 0.6}, {"deceleration_float", 0.2}};
  json["tracing"] = {{"epsilon", 0.004 * w}, {"pull", 0.006 * w}, {"reach", 0.01 * w}, {"lobe_exponent_float", 2000}, {"rest_speed", 0.002 * w}};
  json["time"] = {{"unit", "d"}, {"per_iteration", 0.05}, {"contact", 1.0}};
  json["exchange"] = {{"ratio", 0.4}, {"rates", {{"water", 0.3}, {"dirt", 0.1}}}};
  json["rules"] = Json::array({{{"name", "evaporation"}, {"alpha", 0.5}}, {{"name", "moss"}, {"alpha", 0.02}}});
  json["run"] = {{"iterations", 1000}, {"history_every", 100}, {"controls", {"hits", "water.deposited", "dirt.final"}}};
  return json.dump(2) + "\n";
}

}  // namespace patinate
