/// \file
/// Composition texel by texel in double precision, straight from the formulas: what the integer kernels are tested
/// against.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/simulation/compose.h"
#include "patinate/simulation/material_atlas.h"

namespace patinate::simulation {

struct ReferenceTexel {
  Vec3 color{0, 0, 0};  ///< Linear.
  double specular = 0.0;
  double height_mm = 0.0;
  Vec3 normal{0, 0, 1};  ///< In the frame of glTF, unit.
};

/// All texels in tile order; those outside the charts as above. Colors of materials and new objects are first rounded
/// to sRGB codes, which is what composition works on. Slow: about a microsecond a texel.
[[nodiscard]] std::vector<ReferenceTexel> compose_reference(const Scene& scene, const SceneMesh& scene_mesh,
                                                            const MaterialAtlas& atlas, ColorForm form);

}  // namespace patinate::simulation
