#include "simulation/device/check_scene.h"

#include <array>
#include <string>
#include <utility>

#include "libcommon/core/random.h"

namespace patinate::simulation {

namespace {
constexpr int kResolution = 128;
}

Scene check_scene() {
  Scene scene;
  SceneObject object;
  object.name = "plate";
  object.mesh.positions = {{0, 0, 0}, {50, 0, 0}, {50, 50, 0}, {0, 50, 0}};
  object.mesh.uvs = {{0.05, 0.05}, {0.95, 0.05}, {0.95, 0.95}, {0.02, 0.1}, {0.9, 0.98}, {0.02, 0.98}};
  object.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  object.mesh.uv_triangles = {{0, 1, 2}, {3, 4, 5}};
  object.mesh.triangle_surface = {0, 0};
  object.mesh.surfaces.push_back({"plate", "plate"});
  scene.objects.push_back(std::move(object));
  for (int i = 0; i < 3; ++i) {
    scene.materials.push_back("material" + std::to_string(i));
    MaterialAppearance look;
    look.color.color = Vec3(0.9 - 0.4 * i, 0.2 + 0.3 * i, 0.5);
    look.strength = 0.5 + i;
    look.variation = 0.3 * i;
    look.specular = 0.4 - 0.4 * i;
    look.height_mm = 0.3 * (i - 1);
    look.height_variation = 0.5;
    look.grain_mm = i == 1 ? 4.0 : 0.0;
    if (i == 1) look.second_color = Vec3(0.1, 0.1, 0.8);
    if (i == 2) look.colors = {{.amount = 0.1, .color = {0.1, 0.8, 0.5}}, {.amount = 0.6, .color = {0.8, 0.2, 0.1}}};
    scene.appearance.push_back(std::move(look));
  }
  return scene;
}

CheckSurface::CheckSurface(const Scene& scene)
    : num_materials(static_cast<int>(scene.materials.size())),
      mesh(make_scene_mesh(scene)),
      surface(mesh, kResolution) {}

MaterialAtlas CheckSurface::any_amounts() const {
  MaterialAtlas atlas(surface, num_materials, {std::array<std::uint16_t, kMaxMaterials>{}});
  for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    RandomStream random(3, t);
    for (int m = 0; m < num_materials; ++m)
      atlas.writable_tile(m, TileGrid::tile_of(t))[t % TileGrid::kTileTexels] =
          static_cast<std::uint16_t>(random.below(m == 0 ? 40'000 : 12'000));
  }
  return atlas;
}

}  // namespace patinate::simulation
