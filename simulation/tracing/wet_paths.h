/// \file
/// Wet paths attract drops: to which side of its way a floating gammaton turns.
#pragma once

#include "patinate/simulation/material_atlas.h"

namespace patinate::simulation {

/// Where it is wet, and how strongly that attracts: the tangent of the angle by which a drop turns is `weight` times
/// the difference of what is wet within half a width on both sides of its way, over their sum. What is read does not
/// change while drops respond, so that their order does not matter.
struct WetPaths {
  const MaterialAtlas* atlas = nullptr;
  int material = 0;
  double weight = 0.0;    ///< TracingOptions::wet_attraction.
  double width_mm = 0.0;  ///< TracingOptions::rivulet_mm.
};

}  // namespace patinate::simulation
