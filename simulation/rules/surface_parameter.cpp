#include "simulation/rules/surface_parameter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::simulation {

SurfaceParameter slope_parameter(const SceneMesh& scene_mesh, const SurfaceAtlas& surface, const Vec3& up) {
  const Mesh& mesh = scene_mesh.mesh;
  constexpr double kCancelled = 1e-3;  // of normals of length 1
  std::vector<std::uint16_t> values(surface.grid().num_texels());
  for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    const auto triangle = static_cast<std::size_t>(surface.triangle(t));
    const Vec3 area = area_vector(mesh, surface.triangle(t));
    const std::array<double, 3> weights = surface.corner_weights(t);
    Vec3 normal = Vec3::Zero();
    for (std::size_t k = 0; k < 3 && !mesh.normals.empty(); ++k)
      normal += weights[k] * mesh.normals[static_cast<std::size_t>(mesh.normal_triangles[triangle][k])];
    if (normal.norm() < kCancelled) normal = area;
    if (normal.dot(area) < 0.0) normal = -normal;
    const double length = normal.norm();
    const double slope = length > 0.0 ? (1.0 - normal.dot(up) / length) / 2.0 : 0.0;
    values[t] = static_cast<std::uint16_t>(std::floor(std::clamp(slope, 0.0, 1.0) * 65535.0 + 0.5));
  }
  return {.name = "slope", .values = std::move(values)};
}

SurfaceParameter map_parameter(std::string name, const ImageF& map, const SurfaceAtlas& surface) {
  const TileGrid& grid = surface.grid();
  if (map.width() != grid.width || map.height() != grid.height || map.channels() != 1) {
    throw InvalidInput("the map of `" + name + "` is " + size_text(map.width(), map.height()) + "; the atlas is " +
                       size_text(grid.width, grid.height));
  }
  std::vector<std::uint16_t> values(grid.num_texels());
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const double value = static_cast<double>(map.at(x, y));
      if (surface.is_covered(grid.index(x, y)) && value > 0.0)
        values[grid.index(x, y)] = static_cast<std::uint16_t>(std::floor(std::min(value, 1.0) * 65535.0 + 0.5));
    }
  }
  return {.name = std::move(name), .values = std::move(values)};
}

}  // namespace patinate::simulation
