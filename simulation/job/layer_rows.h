/// \file
/// What became of the layers of a simulation, as simulation.json has it.
#pragma once

#include <string>
#include <vector>

#include "libcommon/document/document.h"
#include "patinate/simulation/engine.h"

namespace patinate::simulation {

/// A LayerAccount in mm3.
struct LayerRow {
  std::string object, layer;
  double start = 0.0, worn = 0.0, flaked = 0.0, remains = 0.0;
};
void describe(DocumentVisitor& v, LayerRow& row);
/// By object, from the substrate outward. Empty in a scene without layers.
[[nodiscard]] std::vector<LayerRow> layer_rows(const Simulation& simulation, const RunControl& control = {});

}  // namespace patinate::simulation
