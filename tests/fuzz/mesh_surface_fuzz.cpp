// The texel map and its walks over the surface, on any mesh that a reader could have made.
#include <cmath>
#include <vector>

#include "libcommon/atlas/texel_map.h"
#include "libcommon/atlas/texel_neighborhood.h"
#include "tests/fuzz/any_mesh.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(mesh_surface) {
  fuzz::ByteSource source(bytes);
  const Mesh mesh = fuzz::any_mesh(source);
  RunControl control;
  control.num_threads = 1;
  const TexelMap map(mesh, 16, 16, control);
  const std::vector<Vec2> offsets{{0.1, 0}, {0, 0.3}, {-2, 1}, {8, -7}};
  std::vector<TexelId> out(offsets.size()), stored(offsets.size());
  const TexelNeighborhood neighborhood(map, offsets, control);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    map.gather(t, offsets, out);
    neighborhood.gather(t, stored);
    fuzz::require(out == stored, "stored and walked neighbours are the same");
    for (TexelId n : out) fuzz::require(n == -1 || (n >= 0 && n < map.num_texels() && map.is_covered(n)), "neighbours are covered texels");
    fuzz::require(map.position_mm(t).allFinite() && map.normal(t).allFinite(), "texels have a place and a normal");
  }
}
