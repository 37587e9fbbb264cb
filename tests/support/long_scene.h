/// \file
/// A scene that is quick to step: for what must hold after very many iterations.
#pragma once

#include "patinate/simulation/scene.h"

namespace patinate::testing_support {

/// An iron plate in 16 turned charts on 64 x 64 texels, so that texels have many areas, in a rain of three drops, with
/// four materials whose rates go from 1/4096 to 1, and rules that make rust and dry water. @param ratio  Of the
/// exchange, [0, 1].
[[nodiscard]] simulation::Scene long_scene(double ratio);

}  // namespace patinate::testing_support
