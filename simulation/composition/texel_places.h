/// \file
/// Where texels lie in space and which way the surface faces there: for what is laid over objects in lengths of their
/// own.
#pragma once

#include <array>
#include <vector>

#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation::composition {

/// Places with objects as they stood when the atlas was made: what is laid on an object stays with it when it moves.
class TexelPlaces {
 public:
  /// @param scene_mesh  Not kept. @param surface  Outlives this.
  TexelPlaces(const SceneMesh& scene_mesh, const SurfaceAtlas& surface);

  [[nodiscard]] const SurfaceAtlas& surface() const { return *surface_; }
  /// mm; 0 outside the charts.
  [[nodiscard]] Vec3 point(TexelIndex t) const;
  /// Normal of the mesh, interpolated; unit, or 0 where it cancels and outside the charts.
  [[nodiscard]] Vec3 normal(TexelIndex t) const;
  [[nodiscard]] std::size_t memory() const;

 private:
  /// Place of a triangle's texels: origin + step * (x, y).
  struct Place {
    Vec3 origin;
    Eigen::Matrix<double, 3, 2> step;
  };

  const SurfaceAtlas* surface_;
  std::vector<Place> places_;
  std::vector<std::array<Eigen::Vector3f, 3>> normals_;  ///< By triangle and corner.
};

}  // namespace patinate::simulation::composition
