// Where a person begins: a mesh that comes into the folder, and a scene that ages it.
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/core/error.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tools/studio/begin_scene.h"
#include "tools/studio/outside_json.h"
#include "tools/studio/routes.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 4> kUploads{".obj", ".ply", ".stl", ".glb"};
constexpr double kMaxDiagonal_m = 10.0;  ///< A mesh of at most this diagonal, whose file knows no unit, is in m.

/// Stem and extension of a mesh by a name from outside: nothing but letters, digits and a few signs stays of it.
std::pair<std::string, std::string> checked_name(const std::string& name) {
  std::string extension = fs::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  if (std::find(kUploads.begin(), kUploads.end(), extension) == kUploads.end())
    throw InvalidInput("\"" + name + "\" is no mesh; choose an OBJ, PLY, STL or GLB file");
  if (!is_file_name(name))
    throw InvalidInput("\"" + name + "\" cannot be the name of a mesh here; use " + file_name_text());
  return {fs::path(name).stem().string(), extension};
}

/// What a mesh is called: by its folder where every second one is called so.
std::string title_of(const fs::path& mesh, const fs::path& root) {
  const std::string stem = mesh.stem().string();
  std::string title = stem == "mesh" && mesh.parent_path() != root ? mesh.parent_path().filename().string() : stem;
  std::replace_if(
      title.begin(), title.end(), [](char c) { return !is_file_name(std::string("a") + c); }, '_');
  return title.substr(0, kLongestFileName / 2);
}

fs::path mesh_of(const Asked& asked) {
  const auto [path, kind] = asked.place();
  if (kind != PlaceKind::Mesh) throw InvalidInput("only a mesh can be aged; this place is none");
  return path;
}

}  // namespace

void write_checked(const fs::path& path, const std::string& name, const std::string& bytes, const FileCheck& check) {
  write_atomically(path, [&](const fs::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw CannotComplete(path.string() + ": cannot be written; is the disk full?");
    try {
      check(temporary);
    } catch (const InputError& e) {
      const std::string text = e.what(), file = temporary.string();
      throw InvalidInput(name + (text.starts_with(file) ? text.substr(file.size()) : ": " + text));
    }
  });
}

HttpResponse save_mesh(const Asked& asked, const std::string& body) {
  const std::string name = asked.target.value("name");
  const auto [stem, extension] = checked_name(name);
  const fs::path path = asked.folder.make_file("", stem, extension);
  try {
    write_checked(path, name, body, [](const fs::path& temporary) { (void)read_mesh(temporary); });
  } catch (...) {
    std::error_code error;
    fs::remove(path, error);
    throw;
  }
  return json_response(Json{{"place", asked.folder.name_of(path)}});
}

HttpResponse answer_begin(const Asked& asked) {
  const fs::path path = mesh_of(asked);
  const Box box = bounding_box(read_mesh(path));
  const Vec3 size = box.high - box.low;
  Json presets = Json::array();
  for (const BeginPreset& preset : begin_presets())
    presets.push_back({{"name", preset.name}, {"title", preset.title}, {"about", preset.about}});
  const bool is_gltf = is_gltf_file(path);
  return json_response(Json{{"size", {size.x(), size.y(), size.z()}},
                            {"unit", is_gltf || box.diagonal() <= kMaxDiagonal_m ? "m" : "mm"},
                            {"has_unit", is_gltf},
                            {"presets", std::move(presets)}});
}

HttpResponse begin_scene(const Asked& asked, const std::string& body) {
  const fs::path path = mesh_of(asked);
  const Json json = parse_outside_json(body);
  JsonReader reader("begin", json);
  BeginOptions options{.preset = reader.member("preset").string(), .unit = reader.member("unit").string()};
  constexpr std::array<std::string_view, 2> kUps{"y", "z"};
  options.is_z_up = reader.member("up").choice(kUps) == 1;
  options.resolution = static_cast<int>(reader.member("resolution").integer(between(64, 4096)));
  reader.finish();
  if (is_gltf_file(path)) options.unit = "m";
  const double size = bounding_box(read_mesh(path)).diagonal();
  if (!(size > 0.0)) throw InvalidInput(asked.folder.name_of(path) + ": the mesh has no size");
  const std::string title = title_of(path, asked.folder.path());
  const std::string text = begin_scene_text(title, path.filename().string(), size, options);
  const std::string parent = fs::path(asked.folder.name_of(path)).parent_path().generic_string();
  const fs::path scene = asked.folder.make_file(parent, title + "_" + options.preset, ".json");
  write_atomically(scene, text);
  return json_response(Json{{"place", asked.folder.name_of(scene)}});
}

}  // namespace patinate::studio
