/// \file
/// Lifted flakes of a simulation's layers as pieces that stand off its surface.
#pragma once

#include <functional>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/output/render_surface.h"
#include "patinate/simulation/engine.h"

namespace patinate::app {

/// Whether lifted flakes are geometry.
struct FlakeOptions {
  bool flakes = true;
};
void describe(OptionVisitor& v, FlakeOptions& o);

/// Maps of a surface as a simulation is composed now.
using ComposedMaps = std::function<SurfaceMaps(const RunControl& control)>;

/// Takes lifted flakes off the surface (simulation/flakes). The maps are those of what lies below the flakes: the next
/// layer, with the materials at the interface. Their pieces are the flakes: maps[0] of their upper sides, maps[1] of
/// their undersides and walls, which show the layer itself with the materials at its interface. The upper sides lie as
/// high as the surface would without lifts. What is lifted and too narrow for a flake lies flat.
/// @param simulation  Gets other amounts and layers.
/// @param relief  Factor of heights below flakes; 0: flakes lie on a surface that no height moves.
/// @returns the maps as they are composed, without pieces, where nothing is lifted.
[[nodiscard]] SurfaceMaps maps_and_flakes(simulation::Simulation& simulation, const ComposedMaps& compose,
                                          const std::function<const TexelMap&()>& map, double relief,
                                          const RunControl& control);

}  // namespace patinate::app
