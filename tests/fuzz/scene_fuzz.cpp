#include <cmath>

#include "patinate/mesh_files/mesh_io.h"
#include "patinate/simulation/scene_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

namespace {

/// A triangle beside the scene, so that a good scene is good.
void make_mesh() {
  static const bool is_made = [] {
    Mesh mesh;
    mesh.positions = {Vec3(0, 0, 0), Vec3(10, 0, 0), Vec3(0, 10, 0)};
    mesh.uvs = {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)};
    mesh.triangles = mesh.uv_triangles = {{0, 1, 2}};
    mesh.triangle_surface = {0};
    mesh.surfaces.push_back({.node = "plate", .material = "tin"});
    write_obj(fuzz::fuzz_folder() / "plate.obj", mesh);
    return true;
  }();
  (void)is_made;
}

}  // namespace

PATINATE_FUZZ_TARGET(scene) {
  make_mesh();
  const simulation::SceneFile file = simulation::read_scene(fuzz::fuzz_file("scene.json", bytes));
  fuzz::require(!file.scene.objects.empty() && !file.scene.emitters.empty(), "a scene has objects and emitters");
  fuzz::require(file.iterations >= 1 && file.history_every >= 1, "a scene runs");
  for (const simulation::Emitter& e : file.scene.emitters)
    fuzz::require(std::abs(e.direction.norm() - 1.0) < 1e-6, "directions are unit");
}
