/// \file
/// What comes along with the program.
#pragma once

#include <string_view>

namespace patinate::simulation {

/// Default appearance parameters and presets: simulation/scene/assets/materials.json.
extern const std::string_view kMaterialLibrary;

}  // namespace patinate::simulation
