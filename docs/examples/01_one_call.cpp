// Ages a mesh as a history aged, keeps the transfer, and writes how the mesh looks at the end.
//     01_one_call HISTORY MESH CONTROL FOLDER TEXTURE.png           e.g. copper bust.glb accessibility aged bust.png
// FOLDER is what `patinate transfer` makes: `patinate render`, `export` and everything else take it.
#include <patinate/patinate.h>

#include <cstdio>
#include <exception>

using namespace patinate;

int main(int argc, char** argv) try {
  if (argc != 6) {
    std::fputs("usage: 01_one_call HISTORY MESH CONTROL FOLDER TEXTURE.png\n", stderr);
    return 2;
  }
  const auto history = read_history(argv[1]);
  const AgingSurface surface = make_aging_surface(read_mesh(argv[2]), {.resolution = 512}, &history->facts());
  const AgedMesh aged = age(history, surface, {{"", control(surface, argv[3])}}, {.seed = 7});  // "": its only control
  aged.save(argv[4]);
  write_color(argv[5], aged.texture(history->times().back()));
  std::printf("%s: control error %.3f\n", argv[4], aged.energy.control_error_mean);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "01_one_call: %s\n", e.what());
  return 1;
}
