/// \file
/// What gammatons carry, and which texels they touch: what passes between tracing and transport.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// A gammaton touches the surface in this iteration; each at most once.
struct Contact {
  TexelIndex texel = 0;
  std::uint32_t gammaton = 0;
  bool is_landing = false;  ///< Out of the air.
  friend bool operator==(const Contact&, const Contact&) = default;
};

/// Mass quanta that each gammaton carries of each material. An amount 1 carried is as much as amount 1 on a texel of
/// median size: kAmountOne * SurfaceAtlas::kMedianWeight quanta.
struct Cargo {
  std::vector<std::array<std::uint32_t, kMaxMaterials>> mass;  ///< By gammaton.
};

}  // namespace patinate::simulation
