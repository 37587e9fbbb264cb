/// \file
/// The maps that drivers, masks and initial amounts name, made for a scene's surface.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/rules/surface_parameter.h"

namespace patinate::simulation {

/// Names of the scene's own maps.
[[nodiscard]] std::vector<std::string> map_names(const Scene& scene);

/// The objects in their own coordinates, as large as they are: what is made of these stays with an object wherever that
/// stands.
[[nodiscard]] SceneMesh in_own_places(const Scene& scene, const SceneMesh& scene_mesh);

/// For each name the scene's map, "slope", or the built-in map.
/// @param names  Of these only. @param scene_mesh  Of the scene, its objects where the maps are to be made of them.
/// @throws InvalidInput naming the map that cannot be made; IoError for a file that one of them reads.
/// Cost: as make_control() for each; a picture or noise 10 ns to 1 us a texel. Same bits for any number of threads.
[[nodiscard]] std::vector<SurfaceParameter> make_parameters(std::span<const std::string> names, const Scene& scene,
                                                            const SceneMesh& scene_mesh, const SurfaceAtlas& surface,
                                                            const RunControl& control);

}  // namespace patinate::simulation
