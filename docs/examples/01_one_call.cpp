// Ages a mesh with a material history in one call, and writes how it looks at the end.
//     01_one_call HISTORY MESH CONTROL TEXTURE.png [TRANSFER]        e.g. copper bust.glb accessibility bust.png aged
// TRANSFER is the folder that `patinate transfer` makes, for `export`, `render` and everything else.
#include <cstdio>
#include <exception>
#include <memory>

#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/transfer/age.h"

using namespace patinate;

int main(int argc, char** argv) try {
  if (argc != 5 && argc != 6) {
    std::fputs("usage: 01_one_call HISTORY MESH CONTROL TEXTURE.png [TRANSFER]\n", stderr);
    return 2;
  }
  const auto history = std::make_shared<const HistoryReader>(argv[1]);
  const transfer::AgedMesh aged = transfer::age_mesh(history, read_mesh(argv[2]), argv[3], {.resolution = 512});
  write_color(argv[4], aged.texture(history->times().back()));
  if (argc == 6) transfer::save_transfer(argv[5], aged);
  std::printf("%s: control error %.3f\n", argv[4], aged.energy.control_error_mean);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "01_one_call: %s\n", e.what());
  return 1;
}
