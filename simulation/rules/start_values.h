/// \file
/// Expressions of what is known at the start of a run: of maps, for an object.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

struct StartExpression {
  std::size_t object = 0;
  std::string text;
  std::string subject;  ///< What messages call it.
};

/// Maps that it asks for. @throws InvalidInput if it cannot be read: it may name maps only, since nothing else is
/// there.
[[nodiscard]] std::vector<std::string> start_names(const Scene& scene, const StartExpression& expression);

/// take(index of the expression, tile, its 64 values) for every expression and tile, one after the other.
/// @throws InvalidInput for an expression or a map that cannot be.
void evaluate_at_start(
    const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface,
    std::span<const StartExpression> expressions,
    const std::function<void(std::size_t index, TileIndex tile, std::span<const float> values)>& take,
    const RunControl& control);

}  // namespace patinate::simulation
