// Composition: everything again after a post-control moved, and a tenth of the tiles; with normals.
#include <cmath>
#include <cstdio>
#include <memory>

#include "libcommon/core/instruction_set.h"
#include "patinate/simulation/compose.h"
#include "tests/benchmarks/simulation_parts.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/meshes.h"
#include "tests/support/threads.h"

namespace patinate::benchmarks {

namespace {

constexpr int kThreads = 2;

/// A plane over the whole atlas; three of seven materials on it everywhere: rust, dirt and water.
simulation::Scene aged_plane(int resolution) {
  simulation::Scene scene;
  scene.materials = {"water", "dirt", "metal", "wood", "organic", "rust", "stone"};
  scene.appearance.resize(7);
  scene.appearance[0] = {.color = {{0.02, 0.02, 0.02}, {}}, .strength = 0.35, .variation = 0.1, .specular = 0.5};
  scene.appearance[1] = {.color = {{0.085, 0.062, 0.04}, {}},
                         .variation = 0.35,
                         .specular = -0.35,
                         .height_mm = 0.08,
                         .height_variation = 0.5};
  scene.appearance[5] = {.color = {{0.2, 0.06, 0.02}, {}},
                         .strength = 1.2,
                         .variation = 0.45,
                         .specular = -0.6,
                         .specular_variation = 0.3,
                         .height_mm = 0.25,
                         .height_variation = 0.6};
  simulation::SceneObject object;
  object.name = "plane";
  object.mesh = testing_support::unit_plane(1000.0, resolution / 16);  // two triangles for 256 texels
  object.preset.amounts[2] = 1.0;
  scene.objects.push_back(std::move(object));
  scene.resolution = resolution;
  return scene;
}

void set_amounts(simulation::MaterialAtlas& atlas, double phase) {
  const simulation::TileGrid& grid = atlas.surface().grid();
  for (const int m : {0, 1, 5}) {
    for (simulation::TileIndex tile = 0; tile < grid.num_tiles(); ++tile) {
      const std::span<std::uint16_t> amounts = atlas.writable_tile(m, tile);
      for (std::uint32_t i = 0; i < 64; ++i) {
        const simulation::TexelIndex t = tile * 64 + i;
        amounts[i] = static_cast<std::uint16_t>(
            4000.0 * (1.0 + std::sin(0.05 * grid.x(t) + m) * std::cos(0.03 * grid.y(t) + phase)));
      }
    }
  }
}

void one_resolution(int resolution, double goal_ms) {
  const simulation::Scene scene = aged_plane(resolution);
  const simulation::SceneMesh mesh = simulation::make_scene_mesh(scene);
  const simulation::SurfaceAtlas surface(mesh, resolution);
  std::array<std::uint16_t, simulation::kMaxMaterials> originals{};
  originals[2] = simulation::kAmountOne;
  simulation::MaterialAtlas atlas(surface, 7, {originals});
  set_amounts(atlas, 0.0);
  std::printf("  %dk:", resolution / 1024);
  for (const InstructionSet set : {InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512}) {
    if (!has_instruction_set(set)) continue;
    simulation::Composer composer(scene, mesh, surface);
    composer.use(set);
    (void)composer.compose(atlas, {}, testing_support::with_threads(kThreads));
    std::vector<simulation::MaterialAppearance> appearance = scene.appearance;
    double turned = 1.0;
    const double dense = median_of_five([&] {
      turned *= 0.97;
      appearance[5].height_mm = 0.25 * turned;  // heights move too, so that all normals are made again
      appearance[5].strength = 1.2 * turned;
      composer.set_appearance(appearance);
      (void)composer.compose(atlas, {}, testing_support::with_threads(kThreads));
    });
    const double color = median_of_five([&] {
      turned *= 0.97;
      appearance[5].strength = 1.2 * turned;
      composer.set_appearance(appearance);
      (void)composer.compose(atlas, {}, testing_support::with_threads(kThreads));
    });
    std::vector<simulation::TileIndex> dirty;
    for (simulation::TileIndex tile = 0; tile < surface.grid().num_tiles(); tile += 10) dirty.push_back(tile);
    double bump = 0.0;
    const double tenth = median_of_five([&] {
      bump += 1.0;
      for (const simulation::TileIndex tile : dirty)
        atlas.writable_tile(5, tile)[0] = static_cast<std::uint16_t>(100.0 * bump);
      (void)composer.compose(atlas, dirty, testing_support::with_threads(kThreads));
    });
    std::printf(" %s %.2f ms, colors only %.2f, a tenth of the tiles %.2f;", kInstructionSetNames[set].data(),
                1e3 * dense, 1e3 * color, 1e3 * tenth);
    if (set == InstructionSet::Avx512) std::printf(" %.0f MB", static_cast<double>(composer.memory()) / 1e6);
  }
  std::printf(" goal %.1f ms%s\n", goal_ms, resolution == 1024 ? ", paper 5.9 ms (GTX 560 Ti)" : "");
}

}  // namespace

void composition() {
  std::printf("everything again with normals after a post-control moved, %d threads, 3 of 7 materials everywhere:\n",
              kThreads);
  one_resolution(1024, 1.5);
  one_resolution(2048, 5.0);
  one_resolution(4096, 20.0);
}

}  // namespace patinate::benchmarks
