#include "tools/patinate/mesh_argument.h"

#include <span>
#include <type_traits>

#include "libcommon/core/error.h"
#include "libcommon/core/hash.h"
#include "libcommon/geometry/mesh_io.h"

namespace patinate {

namespace {

template <class T>
void add_array(ContentHash& hash, const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T> || std::is_same_v<T, Vec2> || std::is_same_v<T, Vec3>);
  hash.add(std::as_bytes(std::span(values)));
}

}  // namespace

void MeshArgument::declare(CommandLine& line) {
  line.positional("MESH", "OBJ, PLY, glTF or GLB with UVs", path);
  line.option("node", "NAME", "Only this node of the file (see `patinate info MESH`)", node);
  line.option("material", "NAME", "Only this material of the file", material);
  line.option("unit", "mm|cm|m", "Length unit of the file, which does not say", unit);
}

std::optional<double> MeshArgument::mm_per_unit() const {
  if (unit.empty()) return std::nullopt;
  if (unit == "mm") return 1.0;
  if (unit == "cm") return 10.0;
  if (unit == "m") return 1000.0;
  throw UsageError("--unit: found `" + unit + "`; expected one of mm, cm, m");
}

Mesh read_mesh_argument(const MeshArgument& argument) {
  Mesh mesh = read_mesh(argument.path);
  if (!argument.node.empty() || !argument.material.empty()) {
    mesh = select_surfaces(mesh, argument.node, argument.material);
  }
  if (!mesh.has_uvs()) {
    throw InvalidInput(argument.path.string() + ": has no UVs; unwrap it first (for example in Blender) and save it with them");
  }
  return mesh;
}

std::string mesh_content_key(const Mesh& mesh) {
  ContentHash hash;
  add_array(hash, mesh.positions);
  add_array(hash, mesh.uvs);
  add_array(hash, mesh.normals);
  add_array(hash, mesh.triangles);
  add_array(hash, mesh.uv_triangles);
  add_array(hash, mesh.normal_triangles);
  return hash.hex();
}

}  // namespace patinate
