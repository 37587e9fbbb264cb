#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "libcommon/core/text.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

namespace {

constexpr double kFarthest = 1e9;  // mm
constexpr double kUvSlack = 1e-6;  // rounding of what a file says

Eigen::Matrix3d rotation_of(const Vec3& degrees) {
  const Vec3 a = degrees * (std::numbers::pi / 180.0);
  return (Eigen::AngleAxisd(a.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(a.y(), Vec3::UnitY()) *
          Eigen::AngleAxisd(a.x(), Vec3::UnitX()))
      .toRotationMatrix();
}

double checked_area(const SceneObject& object) {
  const std::string name = "object '" + object.name + "'";
  if (object.mesh.num_triangles() == 0) throw InvalidInput(name + " has no triangles");
  if (!object.mesh.has_uvs())
    throw InvalidInput(name + " has no UVs; unwrap it, or let the scene do so (\"atlas\": {\"uvs\": \"unwrap\"})");
  for (const Triangle& corners : object.mesh.uv_triangles) {
    for (const int corner : corners) {
      const Vec2& uv = object.mesh.uvs[corner];
      if (uv.minCoeff() >= -kUvSlack && uv.maxCoeff() <= 1.0 + kUvSlack) continue;
      throw InvalidInput(name + " has UVs outside [0, 1]; let the scene unwrap it (\"atlas\": {\"uvs\": \"unwrap\"})");
    }
  }
  double area = 0.0;
  for (int t = 0; t < object.mesh.num_triangles(); ++t) area += 0.5 * area_vector(object.mesh, t).norm();
  area *= object.scale * object.scale;
  if (!(area > 0.0) || !std::isfinite(area)) throw InvalidInput(name + " has no surface");
  return area;
}

/// Squares of the given sides in rows, largest first; false when they do not fit.
bool place_in_rows(const std::vector<int>& sides, const std::vector<std::size_t>& order, int gutter, int resolution,
                   std::vector<std::array<int, 2>>& corners) {
  int x = 0, y = 0, row_height = 0;
  for (const std::size_t i : order) {
    if (x + sides[i] > resolution) {
      x = 0;
      y += row_height + gutter;
      row_height = 0;
    }
    if (x + sides[i] > resolution || y + sides[i] > resolution) return false;
    corners[i] = {x, y};
    x += sides[i] + gutter;
    row_height = std::max(row_height, sides[i]);
  }
  return true;
}

struct Layout {
  std::vector<int> sides;
  std::vector<std::array<int, 2>> corners;
};

/// Texels along the side of the square of an object that asks for a density; 0 for others.
int asked_side(const SceneObject& object, double area, int resolution) {
  if (!object.texels_per_mm) return 0;
  double covered = 0.0;  // Covered share of the unit square.
  for (const Triangle& t : object.mesh.uv_triangles) {
    const auto uv = [&](std::size_t k) { return object.mesh.uvs[t[k]]; };
    const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
    covered += 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
  }
  const double side = *object.texels_per_mm * std::sqrt(area / covered);
  if (side <= resolution) return std::max(1, static_cast<int>(side + 0.5));
  throw InvalidInput("object '" + object.name + "' needs an atlas of " + std::to_string(std::llround(std::ceil(side))) +
                     " texels for its " + number_text(*object.texels_per_mm) + " a mm; there are " +
                     std::to_string(resolution));
}

/// The largest squares, in proportion to the square roots of `areas`, that fit beside those of given sides (0 = free).
Layout lay_out(const std::vector<double>& areas, const std::vector<int>& given, int gutter, int resolution) {
  const std::size_t n = areas.size();
  Layout layout{.sides = given, .corners = std::vector<std::array<int, 2>>(n)};
  double largest = 0.0;
  for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, given[i] > 0 ? 0.0 : std::sqrt(areas[i]));
  std::vector<std::size_t> order(n);
  for (int side = resolution; side >= 1; --side) {
    for (std::size_t i = 0; i < n; ++i) {
      if (given[i] == 0) layout.sides[i] = std::max(1, static_cast<int>(side * std::sqrt(areas[i]) / largest));
    }
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return layout.sides[a] != layout.sides[b] ? layout.sides[a] > layout.sides[b] : areas[a] > areas[b];
    });
    if (place_in_rows(layout.sides, order, gutter, resolution, layout.corners)) return layout;
    if (largest == 0.0) break;  // All are given.
  }
  throw InvalidInput(std::to_string(n) + " objects do not fit into an atlas of " + std::to_string(resolution) +
                     " texels; raise its resolution" + (largest == 0.0 ? " or lower their texels_per_mm" : ""));
}

void append(Mesh& to, const Mesh& from, const Layout& layout, std::size_t object, int resolution) {
  const int first_uv = static_cast<int>(to.uvs.size());
  const int first_position = static_cast<int>(to.positions.size());
  const int first_normal = static_cast<int>(to.normals.size());
  const auto shifted = [](Triangle t, int by) { return Triangle{t[0] + by, t[1] + by, t[2] + by}; };
  to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
  to.normals.insert(to.normals.end(), from.normals.begin(), from.normals.end());
  const double scale = static_cast<double>(layout.sides[object]) / resolution;
  const double u0 = static_cast<double>(layout.corners[object][0]) / resolution;
  const double v0 = 1.0 - static_cast<double>(layout.corners[object][1]) / resolution - scale;
  const bool is_whole = layout.sides[object] == resolution;
  for (const Vec2& uv : from.uvs) {
    const Vec2 inside = uv.cwiseMax(0.0).cwiseMin(1.0);
    to.uvs.push_back(is_whole ? inside : Vec2(u0 + inside.x() * scale, v0 + inside.y() * scale));
  }
  for (const Triangle& t : from.triangles) to.triangles.push_back(shifted(t, first_position));
  for (const Triangle& t : from.uv_triangles) to.uv_triangles.push_back(shifted(t, first_uv));
  for (const Triangle& t : from.normal_triangles) to.normal_triangles.push_back(shifted(t, first_normal));
  to.triangle_surface.insert(to.triangle_surface.end(), from.triangles.size(), static_cast<int>(object));
}

}  // namespace

SceneMesh make_scene_mesh(const Scene& scene, int gutter) {
  if (scene.objects.empty()) throw InvalidInput("the scene has no objects");
  std::vector<double> areas;
  for (const SceneObject& object : scene.objects) areas.push_back(checked_area(object));
  std::vector<int> sides;
  for (std::size_t i = 0; i < areas.size(); ++i)
    sides.push_back(asked_side(scene.objects[i], areas[i], scene.resolution));
  const Layout layout = lay_out(areas, sides, gutter, scene.resolution);
  SceneMesh result;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Mesh mesh = with_crease_normals(scene.objects[i].mesh, scene.objects[i].crease_deg);
    append(result.mesh, mesh, layout, i, scene.resolution);
    result.mesh.surfaces.push_back({.node = scene.objects[i].name, .material = ""});
    result.object.insert(result.object.end(), mesh.triangles.size(), static_cast<std::uint16_t>(i));
    const double side = static_cast<double>(layout.sides[i]) / scene.resolution;
    result.uv_squares.push_back({static_cast<double>(layout.corners[i][0]) / scene.resolution,
                                 1.0 - static_cast<double>(layout.corners[i][1]) / scene.resolution - side, side});
  }
  place_objects(result, scene);
  return result;
}

void place_objects(SceneMesh& scene_mesh, const Scene& scene) {
  std::size_t position = 0;
  std::size_t normal = 0;
  for (const SceneObject& object : scene.objects) {
    const Eigen::Matrix3d rotation = rotation_of(object.rotate_deg);
    const Mesh own = with_crease_normals(object.mesh, object.crease_deg);
    if (position + own.positions.size() > scene_mesh.mesh.positions.size() ||
        normal + own.normals.size() > scene_mesh.mesh.normals.size()) {
      throw InvalidInput("the scene has other objects than when its atlas was made");
    }
    for (const Vec3& p : own.positions) {
      const Vec3 placed = rotation * (p * object.scale) + object.translate_mm;
      if (!(placed.cwiseAbs().maxCoeff() <= kFarthest))
        throw InvalidInput("object '" + object.name +
                           "' lies more than 1000 km from the origin; let its `translate` bring it nearer");
      scene_mesh.mesh.positions[position++] = placed;
    }
    for (const Vec3& n : own.normals) scene_mesh.mesh.normals[normal++] = rotation * n;
  }
  if (position != scene_mesh.mesh.positions.size())
    throw InvalidInput("the scene has other objects than when its atlas was made");
}

}  // namespace patinate::simulation
