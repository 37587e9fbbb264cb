#include "libcommon/geometry/mesh_key.h"

#include <span>

#include "libcommon/core/hash.h"

namespace patinate {

std::string mesh_content_key(const Mesh& mesh) {
  ContentHash hash;
  const auto add = [&](const auto& values) { hash.add(std::as_bytes(std::span(values))); };
  add(mesh.positions);
  add(mesh.uvs);
  add(mesh.normals);
  add(mesh.triangles);
  add(mesh.uv_triangles);
  add(mesh.normal_triangles);
  return hash.hex();
}

}  // namespace patinate
