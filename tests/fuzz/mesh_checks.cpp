#include "tests/fuzz/mesh_checks.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/mesh_files/mesh_io.h"

namespace patinate::fuzz {

namespace {

void check_indices(const std::vector<Triangle>& triangles, std::size_t count, int least, const char* what) {
  for (const Triangle& t : triangles) {
    for (int i : t) require(i >= least && i < static_cast<int>(count), what);
  }
}

template <class Vectors>
void check_finite(const Vectors& vectors, const char* what) {
  require(std::all_of(vectors.begin(), vectors.end(), [](const auto& v) { return v.allFinite(); }), what);
}

void check(const Mesh& mesh) {
  require(!mesh.triangles.empty(), "a mesh has a triangle");
  check_indices(mesh.triangles, mesh.positions.size(), 0, "corners are positions");
  check_indices(mesh.uv_triangles, mesh.uvs.size(), -1, "corners are UVs or none");
  check_indices(mesh.normal_triangles, mesh.normals.size(), 0, "corners are normals");
  for (const auto* list : {&mesh.uv_triangles, &mesh.normal_triangles}) {
    require(list->empty() || list->size() == mesh.triangles.size(), "lists are as long as triangles");
  }
  require(mesh.triangle_surface.size() == mesh.triangles.size(), "every triangle has a surface");
  for (int s : mesh.triangle_surface)
    require(s >= 0 && s < static_cast<int>(mesh.surfaces.size()), "surfaces are known");
  check_finite(mesh.positions, "positions are finite");
  check_finite(mesh.uvs, "UVs are finite");
  check_finite(mesh.normals, "normals are finite");
}

}  // namespace

void read_and_check_mesh(const std::string& name, Bytes bytes) {
  const std::filesystem::path file = fuzz_file(name, bytes);
  std::vector<std::string> notes;
  const Mesh mesh = read_mesh(file, &notes);
  check(mesh);
  (void)mesh_file_extensions(file);
  (void)mesh_buffer_files(file);
  const std::filesystem::path copy = fuzz_folder() / "copy.obj";
  write_obj(copy, mesh);
  const Mesh again = read_mesh(copy);
  check(again);
  require(again.triangles.size() == mesh.triangles.size(), "an OBJ that we write has all of the triangles");
}

}  // namespace patinate::fuzz
