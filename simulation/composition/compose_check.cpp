#include <cmath>
#include <numeric>

#include "libcommon/core/random.h"
#include "patinate/simulation/compose.h"
#include "simulation/composition/compose_device.h"

namespace patinate::simulation {

namespace {

/// Two triangles with borders of their own: some texels have slopes by their tile, some by their real neighbors.
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
    scene.appearance.push_back(std::move(look));
  }
  return scene;
}

}  // namespace

device::CheckResult check_composition(const device::Device& device) {
  constexpr int kResolution = 128;
  const Scene scene = check_scene();
  const SceneMesh mesh = make_scene_mesh(scene);
  const SurfaceAtlas surface(mesh, kResolution);
  MaterialAtlas atlas(surface, static_cast<int>(scene.materials.size()), {std::array<std::uint16_t, kMaxMaterials>{}});
  for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    RandomStream random(3, t);
    for (int m = 0; m < static_cast<int>(scene.materials.size()); ++m)
      atlas.writable_tile(m, TileGrid::tile_of(t))[t % TileGrid::kTileTexels] =
          static_cast<std::uint16_t>(random.below(m == 0 ? 40'000 : 12'000));
  }
  std::optional<device::DeviceError> failure;
  Composer here(scene, mesh, surface), there(scene, mesh, surface);
  there.use(
      std::make_shared<const ComposeDevice>(device, [&](const device::DeviceError& problem) { failure = problem; }));
  (void)here.compose(atlas, {});
  (void)there.compose(atlas, {});
  if (failure) throw device::DeviceError(*failure);
  device::CheckResult check{.num_items = static_cast<std::int64_t>(2 * here.codes().size() + here.normals().size())};
  for (std::size_t i = 0; i < here.codes().size(); ++i)
    check.num_different += here.codes()[i] == there.codes()[i] ? 0 : 1;
  for (std::size_t i = 0; i < here.normals().size(); ++i)
    check.num_different += here.normals()[i] == there.normals()[i] ? 0 : 1;
  for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t)
    check.num_different += here.height_mm(t) == there.height_mm(t) ? 0 : 1;
  return check;
}

}  // namespace patinate::simulation
