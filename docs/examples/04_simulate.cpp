// Rains on a wall with sills until dust has run down it, and writes how it looks and where the rain went.
//     04_simulate FOLDER        makes FOLDER/ledge.obj, scene.json, color.png, hits.exr
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

#include "patinate/datasets/objects.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"

using namespace patinate;

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fputs("usage: 04_simulate FOLDER\n", stderr);
    return 2;
  }
  // A scene is a file: meshes, materials, emitters, rules. This one comes from the library of synthetic data.
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  write_obj(folder / "ledge.obj", datasets::ledge());
  std::ofstream(folder / "scene.json") << datasets::ledge_scene({}, "ledge.obj");

  simulation::SceneFile file = simulation::read_scene(folder / "scene.json");
  file.scene.resolution = 128;  // Texels along the atlas.
  simulation::Simulation simulation(std::move(file.scene), {.parameter_maps = {"hits"}});
  for (int i = 0; i < 40; ++i) simulation.step();

  // No mass is lost: what was emitted and made is on surfaces, carried, or has left.
  const bool balances = simulation.ledger().balances();
  std::printf("%s after %.0f: the mass %s\n", argv[1], simulation.time(), balances ? "balances" : "does not balance");
  write_codes(folder / "color.png", simulation.compose().color_srgb8());
  write_exr(folder / "hits.exr", simulation.parameter_map("hits").values, {"Y"}, ExrDepth::Float);
  return balances ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "04_simulate: %s\n", e.what());
  return 1;
}
