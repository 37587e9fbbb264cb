#include "app/controls/scene_controls.h"

#include <nlohmann/json.hpp>

#include "libcommon/controls/control_expression.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate::app {

namespace fs = std::filesystem;

namespace {

/// Map to give in place of a map of a simulation; "" when it is no map of a scene with several objects.
std::string instead_of(const fs::path& file, const fs::path& simulation) {
  const Json json = load_json(simulation / "simulation.json");
  if (!json.contains("objects") || json["objects"].size() < 2) return "";
  const std::string model = "the mesh " + (simulation / "model.glb").string();
  for (const Json& control : json.value("controls", Json::array())) {
    if ((simulation / control.value("file", "")).lexically_normal() != file) continue;
    if (!control.contains("objects")) return model;
    return "the object's own, as " + (simulation / control["objects"].begin()->get<std::string>()).string() + ", or " +
           model;
  }
  return "";
}

}  // namespace

void refuse_scene_maps(const std::string& text, const fs::path& mesh) {
  const ControlExpression expression(text, control_kind_names());
  for (const ControlName& name : expression.names()) {
    if (!name.is_file) continue;
    const fs::path file = fs::path(name.text).lexically_normal(), simulation = file.parent_path() / "..";
    std::error_code error;
    if (!fs::is_regular_file(simulation / "simulation.json", error)) continue;
    if (fs::equivalent(mesh, simulation / "model.glb", error)) continue;
    const std::string instead = instead_of(file, simulation.lexically_normal());
    if (instead.empty()) continue;
    throw InvalidInput(name.text + ": lies on the atlas of a scene with several objects, not on the UVs of " +
                       mesh.string() + "; give " + instead);
  }
}

}  // namespace patinate::app
