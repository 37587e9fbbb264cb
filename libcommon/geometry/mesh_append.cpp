#include "libcommon/geometry/mesh_append.h"

namespace patinate {

namespace {

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void append_moved(std::vector<Triangle>& to, const std::vector<Triangle>& from, std::size_t by) {
  for (Triangle t : from) {
    for (int& i : t) i += static_cast<int>(by);
    to.push_back(t);
  }
}

}  // namespace

void append_mesh(Mesh& to, const Mesh& from) {
  append_moved(to.triangles, from.triangles, to.positions.size());
  append_moved(to.uv_triangles, from.uv_triangles, to.uvs.size());
  append_moved(to.normal_triangles, from.normal_triangles, to.normals.size());
  for (const int surface : from.triangle_surface)
    to.triangle_surface.push_back(surface + static_cast<int>(to.surfaces.size()));
  append(to.positions, from.positions);
  append(to.uvs, from.uvs);
  append(to.normals, from.normals);
  append(to.surfaces, from.surfaces);
}

}  // namespace patinate
