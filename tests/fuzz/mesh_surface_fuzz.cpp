// The texel map and its walks over the surface, on any mesh that a reader could have made.
#include <cmath>
#include <memory>
#include <vector>

#include "libcommon/atlas/texel_neighborhood.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/atlas/texel_map.h"
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
  std::vector<TexelNeighbor> out(offsets.size());
  const auto frames =
      std::make_shared<const FlowFrames>(direction_frames(map, DirectionKind::Gravity, Vec3(0, 1, 0), control));
  for (const FlowFrame& f : *frames) fuzz::require(f.allFinite(), "frames are numbers");
  const TexelNeighborhood neighborhood(map, offsets, frames, 1.0, control);
  TexelNeighborhood::Cursor cursor(neighborhood);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    map.gather(t, *frames, offsets, out);
    const std::span<const PixelNeighbor> stored = cursor.at(t);
    for (std::size_t k = 0; k < out.size(); ++k) {
      const TexelId n = out[k].texel;
      fuzz::require(n == -1 || (n >= 0 && n < map.num_texels() && map.is_covered(n)), "neighbors are covered texels");
      fuzz::require(stored[k].texel == n || stored[k].texel == -1,
                    "stored and walked neighbors are the same, or too far away");
    }
    fuzz::require(map.position_mm(t).allFinite() && map.normal(t).allFinite(), "texels have a place and a normal");
  }
}
