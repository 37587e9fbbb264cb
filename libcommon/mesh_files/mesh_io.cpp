#include "patinate/mesh_files/mesh_io.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/regular_file.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "libcommon/mesh_files/mesh_formats.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

const std::string kObjBegin = "# patinate";
constexpr const char* kObjEnd = "# end\n";  ///< End of a file with a key, which is so known to be whole.

template <class Number>
void append(std::string& text, Number value) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  text.append(buffer, result.ptr);
}

template <class Vector>
void append_vectors(std::string& text, const char* keyword, const std::vector<Vector>& vectors) {
  for (const Vector& v : vectors) {
    text += keyword;
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      if (!std::isfinite(v[i])) throw InvalidInput("write_obj: the mesh holds a value that is not finite");
      text += ' ';
      append(text, v[i]);
    }
    text += '\n';
  }
}

/// A name as one OBJ statement can hold it: no new line, comment, or continued line.
std::string statement_name(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '#' || c == '\\'; }, '_');
  return name;
}

/// A material stays in force until the next one: among others, one without a name is said too.
void append_surface(std::string& text, const Mesh::Surface& surface, bool says_materials) {
  text += "o " + statement_name(surface.node) + '\n';
  if (says_materials) text += "usemtl " + statement_name(surface.material) + '\n';
}

}  // namespace

Mesh read_mesh(const std::filesystem::path& path, std::vector<std::string>* notes) {
  const std::string extension = lower_extension(path);
  const bool is_gltf = is_gltf_file(path);
  if (extension != ".obj" && extension != ".ply" && extension != ".stl" && !is_gltf) {
    throw IoError(path.string(),
                  "no mesh format has the extension `" + extension + "`; use .obj, .ply, .stl, .gltf or .glb");
  }
  require_regular_file(path);
  std::error_code error;
  if (std::filesystem::file_size(path, error) == 0 && !error) {
    throw IoError(path.string(), "the file is empty (0 bytes)");
  }
  if (is_gltf) return read_gltf(path, notes);
  if (extension == ".stl") return read_stl(path);
  return extension == ".obj" ? read_obj(path) : read_ply(path);
}

void write_obj(const std::filesystem::path& path, const Mesh& mesh, const std::string& key) {
  write_obj(path, mesh, key, "");
}

void write_obj(const std::filesystem::path& path, const Mesh& mesh, const std::string& key,
               const std::string& material_library) {
  const bool has_uvs = mesh.has_uvs();
  const bool has_normals = !mesh.triangles.empty() && mesh.normal_triangles.size() == mesh.triangles.size();
  std::string text = kObjBegin + (key.empty() ? "" : " " + key) + "\n";
  if (!material_library.empty()) text += "mtllib " + statement_name(material_library) + "\n";
  append_vectors(text, "v", mesh.positions);
  if (has_uvs) append_vectors(text, "vt", mesh.uvs);
  if (has_normals) append_vectors(text, "vn", mesh.normals);
  const bool says_materials = std::any_of(mesh.surfaces.begin(), mesh.surfaces.end(),
                                          [](const Mesh::Surface& s) { return !s.material.empty(); });
  int surface = -1;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const int s = t < mesh.triangle_surface.size() ? mesh.triangle_surface[t] : -1;
    if (s != surface) {
      append_surface(text, mesh.surfaces[s], says_materials);
      surface = s;
    }
    text += 'f';
    for (std::size_t k = 0; k < 3; ++k) {
      text += ' ';
      append(text, mesh.triangles[t][k] + 1);
      if (has_uvs || has_normals) text += '/';
      if (has_uvs) append(text, mesh.uv_triangles[t][k] + 1);
      if (has_normals) {
        text += '/';
        append(text, mesh.normal_triangles[t][k] + 1);
      }
    }
    text += '\n';
  }
  if (!key.empty()) text += kObjEnd;
  write_atomically(path, text);
}

std::string read_obj_key(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return "";
  std::ifstream file(path);
  std::string line(128, '\0');
  file.read(line.data(), static_cast<std::streamsize>(line.size()));
  line.resize(file.gcount());
  line.resize(std::min(line.size(), line.find('\n')));
  if (line.compare(0, kObjBegin.size() + 1, kObjBegin + " ") != 0) return "";
  return line.substr(kObjBegin.size() + 1);
}

}  // namespace patinate
