/// \file
/// The surface behind an atlas without its facets: what maps stand on that look at angles between neighboring points.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// The mesh of a TexelMap, its edges halved until none is longer than `max_edge_mm` (and at most `max_triangles`), new
/// points on the curve that the shading normals ask for (RefineShape::Curved), so that a low-polygon sphere casts no
/// shadows on itself and its facets are no valleys; planes and hard edges stay as they are.
class SmoothSurface {
 public:
  /// @param map  Must outlive this.
  /// @throws InvalidInput unless max_edge_mm > 0.
  SmoothSurface(const TexelMap& map, double max_edge_mm, int max_triangles, const RunControl& control = {});

  [[nodiscard]] const TexelMap& map() const { return map_; }
  [[nodiscard]] const Mesh& mesh() const { return fine_->mesh(); }
  /// Where a texel lies on mesh(); nothing where rounding left a texel on an edge to no fine triangle.
  [[nodiscard]] std::optional<SurfacePoint> point(TexelId t) const;
  /// Position of a texel that map() covers.
  [[nodiscard]] Vec3 position_mm(TexelId t) const;
  [[nodiscard]] Vec3 normal(TexelId t) const;
  /// Values at the positions of mesh(), interpolated to the texels that map() covers.
  [[nodiscard]] ImageF to_texels(const std::vector<double>& values) const;
  /// Fills covered texels without a point() from their nearest neighbors.
  void fill_gaps(ImageF& image) const;

 private:
  const TexelMap& map_;
  std::unique_ptr<const TexelMap> fine_;
};

}  // namespace patinate
