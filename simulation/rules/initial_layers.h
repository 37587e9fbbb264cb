/// \file
/// Thicknesses and adhesion of layers at the start that differ from place to place.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/layer_atlas.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// Maps that a layer's thickness and adhesion ask for. @throws InvalidInput if one of them cannot be read.
[[nodiscard]] std::vector<std::string> layer_map_names(const Scene& scene, std::size_t object, std::size_t layer);

/// Gives every texel the thicknesses, the adhesion, the cracks and their strength and directions that its object's
/// layers state, finds which layer shows, and opens the accounts. @param layers  New. @throws InvalidInput for an
/// expression or a map that cannot be. Same bits for any number of threads and instruction set.
void lay_initial_layers(const Scene& scene, const SceneMesh& scene_mesh, LayerAtlas& layers,
                        const RunControl& control = {});

/// Moves layers of a snapshot in place of those of the same scene. What that states of cracks and a snapshot does not
/// hold, their strength and directions, stays.
void replace_layers(LayerAtlas&& restored, LayerAtlas& layers);

}  // namespace patinate::simulation
