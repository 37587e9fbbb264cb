#include "tests/simulation/transport/transport_scene.h"

#include "libcommon/core/random.h"
#include "tests/support/meshes.h"

namespace patinate::testing_support {

namespace {

TransportScene scene_of(Mesh mesh, int resolution) {
  simulation::Scene scene;
  simulation::SceneObject object;
  object.name = "plane";
  object.mesh = std::move(mesh);
  scene.objects.push_back(std::move(object));
  TransportScene out;
  out.surface = std::make_unique<simulation::SurfaceAtlas>(simulation::make_scene_mesh(scene), resolution);
  out.atlas =
      std::make_unique<simulation::MaterialAtlas>(*out.surface, 3,
                                                  std::vector<std::array<std::uint16_t, simulation::kMaxMaterials>>{
                                                      {0, simulation::kAmountOne, simulation::kAmountOne / 2}});
  for (simulation::TexelIndex t = 0; t < out.surface->grid().num_texels(); ++t) {
    if (out.surface->is_covered(t)) out.covered.push_back(t);
  }
  return out;
}

}  // namespace

TransportScene squeezed_plane(int resolution) {
  Mesh mesh = unit_plane(100, 16);
  for (Vec2& uv : mesh.uvs) uv.x() = 0.05 * uv.x() + 0.9 * uv.x() * uv.x();
  return scene_of(std::move(mesh), resolution);
}

TransportScene seamed_plane(int resolution) { return scene_of(cut_plane(100), resolution); }

std::vector<simulation::Contact> random_contacts(const TransportScene& scene, std::uint32_t n, std::uint64_t seed,
                                                 std::uint32_t crowding) {
  RandomStream random(seed, 0);
  std::vector<simulation::Contact> contacts;
  for (std::uint32_t g = 0; g < n; ++g) {
    const std::uint32_t i = random.below(static_cast<std::uint32_t>(scene.covered.size()));
    contacts.push_back({scene.covered[i / crowding * crowding], g});
  }
  return contacts;
}

simulation::Cargo random_cargo(std::uint32_t n, double most, std::uint64_t seed) {
  RandomStream random(seed, 1);
  simulation::Cargo cargo;
  cargo.mass.resize(n);
  for (auto& mass : cargo.mass) {
    for (std::size_t m = 0; m < 3; ++m)
      mass[m] = static_cast<std::uint32_t>(random.uniform() * most * simulation::kAmountOne *
                                           simulation::SurfaceAtlas::kMedianWeight);
  }
  return cargo;
}

std::int64_t cargo_mass(const simulation::Cargo& cargo, std::size_t material) {
  std::int64_t sum = 0;
  for (const auto& mass : cargo.mass) sum += mass[material];
  return sum;
}

}  // namespace patinate::testing_support
