#include "tests/benchmarks/wall_scene.h"

#include <filesystem>

#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "patinate/datasets/objects.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/simulation/scene_io.h"

namespace patinate::benchmarks {

simulation::Scene wall(int resolution) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "patinate_simulation_benchmark";
  std::filesystem::create_directories(folder);
  write_obj(folder / "mesh.obj", datasets::ledge());
  write_atomically(folder / "scene.json", datasets::ledge_scene({}, "mesh.obj"));
  simulation::Scene scene = simulation::read_scene(folder / "scene.json").scene;
  std::filesystem::remove_all(folder);
  scene.resolution = resolution;
  scene.emitters[0].gammatons = 4000;
  scene.emitters[1].gammatons = 1000;
  return scene;
}

simulation::Scene slow_wall(int resolution) {
  simulation::Scene scene = wall(resolution);
  scene.rules[0].rate = 0.05;
  return scene;
}

void make_wet(simulation::Simulation& simulation, double share) {
  const int n = simulation.scene().resolution;
  ImageF water(n, n, 1);
  RandomStream random(1, 0);
  for (int y = 0; y < n; y += 8) {
    for (int x = 0; x < n; x += 8) {
      if (random.uniform() >= share) continue;
      for (int k = 0; k < 64; ++k) water.at(x + k % 8, y + k / 8) = 0.5F;
    }
  }
  simulation.set_amounts(0, water);
}

double wet_share(const simulation::Simulation& simulation) {
  const simulation::SurfaceAtlas& surface = simulation.atlas().surface();
  std::int64_t wet = 0;
  for (simulation::TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (surface.is_covered(t) && simulation.atlas().amount(0, t) > 0) ++wet;
  }
  return static_cast<double>(wet) / static_cast<double>(surface.num_covered());
}

}  // namespace patinate::benchmarks
