/// \file
/// What checks of a device's kernels work on.
#pragma once

#include "patinate/simulation/material_atlas.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// A plate of two triangles with borders of their own, and three materials with every kind of look.
[[nodiscard]] Scene check_scene();

/// Its surface and any amounts.
struct CheckSurface {
  explicit CheckSurface(const Scene& scene);
  [[nodiscard]] MaterialAtlas any_amounts() const;

  int num_materials;
  SceneMesh mesh;
  SurfaceAtlas surface;
};

}  // namespace patinate::simulation
