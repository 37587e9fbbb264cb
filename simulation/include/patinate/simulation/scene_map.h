/// \file
/// Maps of the surface that a scene gives names to, for drivers of rules, masks and initial amounts.
#pragma once

#include <string>
#include <vector>

#include "patinate/controls/control_kinds.h"
#include "patinate/controls/noise.h"
#include "patinate/controls/wood_grain.h"
#include "patinate/image/image.h"

namespace patinate::simulation {

/// A map with a value in [0, 1] at every place, computed once for the objects' positions at the start.
struct SceneMap {
  std::string name;             ///< As expressions have it: letters, digits and `_`, no digit first.
  std::string kind;             ///< One of scene_map_kinds().
  ControlKindOptions options;   ///< Of a kind of control_kinds(); its paths lead from the working folder.
  NoiseOptions noise;           ///< Of "noise", which belongs to each object's own coordinates (times its scale).
  WoodGrainOptions wood_grain;  ///< Of "wood_grain": each piece of an object that hangs together is a board.
  std::vector<ImageF> images;   ///< Of "image": by object, over its UVs, of one channel; an empty one is 0.
  std::vector<bool> is_inside;  ///< Of "objects": by object, whether it is 1 there.
};

/// Those of control_kind_names(), "noise", "wood_grain" and "objects".
[[nodiscard]] const std::vector<std::string>& scene_map_kinds();

/// Kinds that drivers may name without a map of the scene: those that need no input, with default options. Up is
/// against gravity.
[[nodiscard]] const std::vector<std::string>& built_in_maps();

/// Says whether an expression can use the text as a name.
[[nodiscard]] bool is_map_name(const std::string& text);

}  // namespace patinate::simulation
