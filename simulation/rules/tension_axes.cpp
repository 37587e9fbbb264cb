#include "simulation/rules/tension_axes.h"

#include <Eigen/LU>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "simulation/layers/chart_walk.h"
#include "simulation/rules/boards.h"
#include "simulation/rules/scene_maps.h"

namespace patinate::simulation {

namespace {

/// A direction's projection to a triangle's plane, along its row of texels and at right angles to it.
/// @param corners  Of the triangle, in the atlas, texels.
SurfaceVector projected(const Vec3& direction, const Mesh& mesh, std::size_t triangle,
                        const std::array<float, 6>& corners) {
  const Triangle& t = mesh.triangles[triangle];
  Eigen::Matrix<double, 3, 2> sides;
  sides << mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]];
  Eigen::Matrix2f texels;
  texels << corners[2] - corners[0], corners[4] - corners[0], corners[3] - corners[1], corners[5] - corners[1];
  if (texels.determinant() == 0.0F) return {};
  const Eigen::Matrix<double, 3, 2> steps = sides * texels.cast<double>().inverse();
  const Vec3 row = steps.col(0).normalized(), column = (steps.col(1) - steps.col(1).dot(row) * row).normalized();
  return {static_cast<float>(direction.dot(row)), static_cast<float>(direction.dot(column))};
}

}  // namespace

void lay_tension_axes(const Scene& scene, const SceneMesh& scene_mesh, LayerAtlas& layers) {
  std::optional<Mesh> mesh;  // in the objects' own places, made where it is asked for
  Boards boards;
  const auto find = [&] {
    const SceneMesh own = in_own_places(scene, scene_mesh);
    boards = find_boards(own, std::vector<std::int64_t>(scene.objects.size()));
    mesh = own.mesh;
  };
  for (int l = 1; l < layers.num_layers(); ++l) {
    for (int o = 0; o < layers.num_objects(); ++o) {
      if (l >= layers.num_layers(o) || !layers.cracks(o, l) || !layers.cracks(o, l)->tension) continue;
      if (!mesh) find();
      std::vector<SurfaceVector>& axes = layers.tension_axes(l);
      axes.resize(mesh->triangles.size());
      for (std::size_t t = 0; t < axes.size(); ++t) {
        if (scene_mesh.object[t] != o) continue;
        const Vec3 along = layers.cracks(o, l)->tension->along.value_or(boards.boards[boards.of_triangle[t]].along);
        axes[t] = projected(along, *mesh, t, layers.surface().corner_texels()[t]);
      }
    }
  }
}

}  // namespace patinate::simulation
