/// \file
/// Parameter maps of scenes with several objects, given for the mesh of one.
#pragma once

#include <filesystem>
#include <string>

namespace patinate::app {

/// @param text  A control expression. @param mesh  What it is for.
/// @throws InvalidInput if it names a parameter map on the atlas of a simulation with several objects, unless `mesh` is
/// that simulation's model: on another mesh's UVs the map means nothing.
void refuse_scene_maps(const std::string& text, const std::filesystem::path& mesh);

}  // namespace patinate::app
