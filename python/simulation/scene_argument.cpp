#include "python/simulation/scene_argument.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "patinate/mesh_files/mesh_io.h"
#include "python/support/json.h"
#include "simulation/files/scene_files.h"

namespace patinate::python {

namespace py = pybind11;
namespace fs = std::filesystem;

namespace {

/// Writes a scene with its meshes into `folder`. @param base  What its paths lead from. @returns its file
fs::path write_scene(Json root, const fs::path& base, const MeshesByPath& meshes, const fs::path& folder) {
  std::size_t count = 0;
  simulation::for_each_scene_path(root, [&](Json& path) {
    const auto given = meshes.find(base / path.get<std::string>());
    if (given == meshes.end())
      return simulation::move_scene_path(path, fs::absolute(base.empty() ? "." : base), folder);
    const std::string name = "mesh" + std::to_string(count++) + ".obj";
    write_obj(folder / name, *given->second);
    path = name;
  });
  save_json(folder / "scene.json", root);
  return folder / "scene.json";
}

}  // namespace

simulation::SceneFile SceneArgument::read(const RunControl& control) const {
  simulation::SceneAssets assets;
  assets.given_meshes = meshes;
  return simulation::read_scene(file, root ? *root : load_json(file), assets, control);
}

fs::path SceneArgument::written(std::optional<TemporaryFolder>& room, const RunControl& control) const {
  if (!root && meshes.empty()) return file;
  (void)read(control);  // What is wrong is said of the scene, not of the file below.
  room.emplace(fs::temp_directory_path(), "patinate_scene");
  return write_scene(root ? *root : load_json(file), file.parent_path(), meshes, room->path());
}

FunctionText& scene_text(FunctionText& text) {
  return text.keyword("folder", "str | os.PathLike[str]", "'.'", "Of a scene that is no file: what its paths lead from")
      .keyword("meshes", "Mapping[str, Mesh] | None", "None",
               "In place of files, by the name that an object's \"mesh\" has in the scene; in the scene's unit");
}

SceneArgument scene_from(const char* function, const py::object& scene, Keywords& keywords) {
  const py::object meshes = keywords.object("meshes");
  const std::string folder = keywords.text("folder", ".");
  const bool is_dict = py::isinstance<py::dict>(scene);
  SceneArgument out;
  if (is_dict) out.root = std::make_shared<const Json>(json_from(scene, "scene"));
  out.file = is_dict ? fs::path(folder) / "scene" : fs::path(path_from(scene));
  out.meshes = meshes_from(function, meshes, out.file.parent_path());
  return out;
}

}  // namespace patinate::python
