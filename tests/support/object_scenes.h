/// \file
/// Scenes of synthetic objects, as a user would simulate them.
#pragma once

#include "patinate/simulation/scene.h"

namespace patinate::testing_support {

/// `synth ledge`: a wall with sills on which dust settles, and rain that takes it down the wall.
[[nodiscard]] simulation::Scene wall_scene(int resolution);

/// `synth sculpture` of iron in rain and in splashes from below: rust under handles, lid and band, which a run carries
/// down. Overhangs drip.
[[nodiscard]] simulation::Scene urn_scene(int resolution);

}  // namespace patinate::testing_support
