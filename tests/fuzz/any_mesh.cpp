#include "tests/fuzz/any_mesh.h"

#include <cmath>

namespace patinate::fuzz {

Mesh any_mesh(ByteSource& source) {
  const auto finite = [&] {
    const float v = source.number();
    return std::isfinite(v) ? static_cast<double>(v) : 0.0;
  };
  Mesh mesh;
  const int num_positions = source.integer(1, 12), num_uvs = source.integer(1, 12),
            num_triangles = source.integer(1, 24);
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

}  // namespace patinate::fuzz
