/// \file
/// The smallest scene in which something ages.
#pragma once

#include "patinate/simulation/scene.h"

namespace patinate::testing_support {

/// An iron plate of 100 mm in one chart, tilted by 30 degrees, in a rain of 200 drops that leave water; materials
/// water, metal, rust (red-brown). No rule yet.
/// @param resolution  Texels along a side.
[[nodiscard]] simulation::Scene plate_scene(int resolution);

/// Rust from min(water, metal). @param alpha  Its rate, 1 / time.
[[nodiscard]] simulation::Rule rust_rule(double alpha);

}  // namespace patinate::testing_support
