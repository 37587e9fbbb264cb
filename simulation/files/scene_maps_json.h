/// \file
/// "maps" of a scene file, and what names them: masks of rules and initial amounts. For scene_io.cpp.
#pragma once

#include <string>

#include "simulation/files/scene_json.h"

namespace patinate::simulation {

/// "maps": {"damp": {"kind": "distance", "from": "creases", "range_mm": 30}, ...} into scene.maps. Options are those of
/// `patinate control` without the kind's own name before them, lengths with `_mm` behind; "image" takes a picture for
/// all objects, or "images" by object.
/// @param scene  With its materials and objects.
void read_maps(JsonReader json, const SceneContext& context, Scene& scene);

/// Reads what limits a rule: an expression, a list of objects, or a map of its own as in "maps", which comes to
/// scene.maps.
/// @returns an expression. @throws IoError
[[nodiscard]] std::string read_mask(const JsonReader& json, const SceneContext& context, Scene& scene);

/// Looks whether the pattern of a preset is a map. @param json  Where it is named. @param scene  With its maps.
void check_pattern(const JsonReader& json, const Preset& preset, const Scene& scene);

/// A number, an expression of maps, or a map of its own as in "maps" with "amount" for what its 1 stands for.
/// @param word  Begins the name of such a map. @returns an expression.
[[nodiscard]] std::string read_start_value(JsonReader json, const Range& range, const std::string& word,
                                           const SceneContext& context, Scene& scene);

/// "initial" of an object: read_start_value() by material. @param scene  With its maps.
void read_initial(JsonReader json, const SceneContext& context, Scene& scene, std::size_t object);

}  // namespace patinate::simulation
