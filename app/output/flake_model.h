/// \file
/// Lifted flakes in models.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/output/aging_glb.h"
#include "app/output/simulated_maps.h"
#include "patinate/core/run_control.h"

namespace patinate::app {

/// Adds, for every time at which there are lifted flakes, a tile of their upper sides and one of their undersides and
/// walls, seen at that time alone (GlbTiles::only_in). The surface gets the textures of what lies below them then. At
/// other times nothing changes; without any flakes nothing does.
/// @param parts  Of a simulation: one tile, and an appearance for each time.
/// @param surface  Flakes lie on it as it is without heights. @param labels  Names of times.
/// @param are_objects  Flakes of a time are one object, else each belongs to the object that it lies on.
void add_flakes_to(ModelParts& parts, const std::shared_ptr<SimulatedSurface>& surface,
                   const std::vector<double>& times, const std::vector<std::string>& labels, bool are_objects,
                   const RunControl& control);

}  // namespace patinate::app
