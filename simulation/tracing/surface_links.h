/// \file
/// Which triangle lies beyond an edge: for gammatons that run over a surface.
#pragma once

#include <span>
#include <vector>

#include "patinate/simulation/surface_atlas.h"
#include "simulation/tracing/motion_facts.h"

namespace patinate::simulation {

/// Triangles of one object that share an edge, by their corners' places: UV seams, hard edges and materials do not cut.
/// Where more than two meet, those that bend least are joined (triangle_neighbors()). 12 bytes a triangle.
class SurfaceLinks {
 public:
  explicit SurfaceLinks(const SceneMesh& scene_mesh);

  /// By triangle.
  [[nodiscard]] std::span<const TriangleLinks> codes() const { return codes_; }
  void prefetch([[maybe_unused]] int triangle) const {
#if defined(__GNUC__)
    if (triangle >= 0) __builtin_prefetch(&codes_[triangle]);
#endif
  }

 private:
  std::vector<TriangleLinks> codes_;
};

}  // namespace patinate::simulation
