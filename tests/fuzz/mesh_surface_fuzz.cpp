// The texel map and its walks over the surface, on any mesh that a reader could have made.
#include <cmath>
#include <vector>

#include "libcommon/atlas/texel_map.h"
#include "libcommon/atlas/texel_neighborhood.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

namespace {

/// Finite, as readers give it; everything else may be as odd as it likes.
Mesh any_mesh(fuzz::ByteSource& source) {
  const auto finite = [&] {
    const float v = source.number();
    return std::isfinite(v) ? static_cast<double>(v) : 0.0;
  };
  Mesh mesh;
  const int num_positions = source.integer(1, 12), num_uvs = source.integer(1, 12), num_triangles = source.integer(1, 24);
  for (int i = 0; i < num_positions; ++i) {
    const double x = finite(), y = finite(), z = finite();
    mesh.positions.emplace_back(x, y, z);
  }
  for (int i = 0; i < num_uvs; ++i) {
    const double u = source.byte() / 255.0, v = source.byte() / 255.0;
    mesh.uvs.emplace_back(u, v);
  }
  for (int i = 0; i < num_triangles; ++i) {
    Triangle corners{}, uvs{};
    for (int& c : corners) c = source.byte() % num_positions;
    for (int& c : uvs) c = source.byte() % num_uvs;
    mesh.triangles.push_back(corners);
    mesh.uv_triangles.push_back(uvs);
  }
  mesh.surfaces = {{"", ""}};
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  return mesh;
}

}  // namespace

PATINATE_FUZZ_TARGET(mesh_surface) {
  fuzz::ByteSource source(bytes);
  const Mesh mesh = any_mesh(source);
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
