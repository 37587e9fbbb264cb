#include <array>

#include "patinate/mesh_files/mesh_io.h"
#include "patinate/output/glb.h"
#include "patinate/output/movie.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// Bytes that stand where an output is to go: anything may lie there. The first byte chooses the kind of file.
PATINATE_FUZZ_TARGET(output_key) {
  if (bytes.empty()) return;
  const fuzz::Bytes rest = bytes.subspan(1);
  switch (bytes[0] % 4) {
    case 0:
      (void)read_obj_key(fuzz::fuzz_file("a.obj", rest));
      break;
    case 1:
      (void)read_glb_key(fuzz::fuzz_file("a.glb", rest));
      break;
    case 2:
      (void)read_movie_key(fuzz::fuzz_file("a.gif", rest));
      break;
    default:
      (void)read_movie_key(fuzz::fuzz_file("a.mp4", rest));
      break;
  }
}
