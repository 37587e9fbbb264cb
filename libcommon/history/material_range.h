/// \file
/// What maps of a material may hold.
#pragma once

#include <optional>
#include <string>

#include "patinate/image/image.h"

namespace patinate {

/// Of those that a history may also have as a map that is constant in time.
[[nodiscard]] inline bool is_material_map(const std::string& name) {
  return name == "specular" || name == "metalness" || name == "tint";
}

/// "holds 1.2; ..." where a metalness or a tint leaves [0, 1]; nothing when all is well, or for other names.
[[nodiscard]] std::optional<std::string> find_material_problem(const std::string& name, const ImageF& values);

}  // namespace patinate
