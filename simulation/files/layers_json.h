/// \file
/// "layers" of an object or a preset of a scene file. For scene_io.cpp.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "simulation/files/scene_json.h"

namespace patinate::simulation {

/// The preset that a member names. @throws IoError with the names that there are, and a did-you-mean.
[[nodiscard]] const Preset& preset_named(const JsonReader& json, const std::map<std::string, Preset>& presets);

/// The layers of an object, from the substrate outward: each a "name", and the members of a preset or the name of one;
/// those above the substrate have a "thickness_um" and may have an "adhesion" as "initial" has amounts. The substrate
/// becomes the object's preset, which alone it is of where there is no other layer. @param scene  With its maps.
void read_layers(const JsonReader& json, const SceneContext& context, const std::map<std::string, Preset>& presets,
                 Scene& scene, std::size_t object);

}  // namespace patinate::simulation
