/// \file
/// What maps of a material may hold.
#pragma once

#include <optional>
#include <string>

#include "patinate/image/image.h"

namespace patinate {

/// Names the maps that a history may also have once, constant in time.
[[nodiscard]] inline bool is_material_map(const std::string& name) {
  return name == "specular" || name == "metalness" || name == "tint";
}

/// "holds 1.2; ..." where a metalness, a tint or a roughness leaves [0, 1], a strength is below 0, or a normal is
/// longer than 1 or shorter than half of it and not 0; or where all normals are 0. Nothing when all is well, or for
/// other names.
[[nodiscard]] std::optional<std::string> find_material_problem(const std::string& name, const ImageF& values);

}  // namespace patinate
