/// \file
/// Amounts at the start that differ from place to place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/material_atlas.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// Maps that an object's initial amount of a material asks for. @throws InvalidInput if it cannot be read: it may name
/// maps only, since nothing else is there at the start.
[[nodiscard]] std::vector<std::string> initial_names(const Scene& scene, std::size_t object, int material);

/// Mass by material.
struct LaidAmounts {
  std::array<std::int64_t, kMaxMaterials> more{};  ///< Laid down beyond the objects' presets.
  std::array<std::int64_t, kMaxMaterials> less{};  ///< Taken away from them.
};

/// Gives every texel the amounts that its object's SceneObject::initial says, rounded to quanta. Originals stay those
/// of the presets, so that what is laid down shows.
/// @param atlas  As it is at the start. @throws InvalidInput for an expression or a map that cannot be.
/// Same bits for any number of threads and instruction set.
LaidAmounts lay_initial_amounts(const Scene& scene, const SceneMesh& scene_mesh, MaterialAtlas& atlas,
                                const RunControl& control = {});

}  // namespace patinate::simulation
