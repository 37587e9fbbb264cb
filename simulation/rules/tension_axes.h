/// \file
/// Directions in which layers that crack are under another tension.
#pragma once

#include "patinate/simulation/layer_atlas.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// Makes LayerAtlas::tension_axes() of what the layers state. They stay with an object that is moved or turned later.
/// @param scene_mesh  Of the scene.
void lay_tension_axes(const Scene& scene, const SceneMesh& scene_mesh, LayerAtlas& layers);

}  // namespace patinate::simulation
