/// \file
/// A surface as a height function toward a viewer, and its mean curvature at a physical scale.
#pragma once

#include <optional>

#include "libcommon/geometry/ray_scene.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate {

/// Heights on a square grid. Column x, row y is the point origin + spacing_mm (x right + y down) + height(x, y) viewer.
/// Axes are unit and at right angles, right x down = -viewer.
struct HeightField {
  Image<double> height_mm;  ///< Toward the viewer; 0 outside `seen`.
  ImageU8 seen;             ///< 255 where there is surface.
  double spacing_mm = 1.0;  ///< > 0.
  Vec3 origin = Vec3::Zero();
  Vec3 right = Vec3::UnitX();
  Vec3 down = -Vec3::UnitY();
  Vec3 viewer = Vec3::UnitZ();

  /// Column and row above which a point lies, fractions included.
  [[nodiscard]] Vec2 grid_position(const Vec3& point) const;
};

/// Surface seen from far along `viewer`: the first surface under every point of a grid over the mesh's bounding box.
/// @param scene       Of `mesh`.
/// @param viewer      Unit vector from the surface to the viewer.
/// @param spacing_mm  > 0; made larger where the grid would have more than 4096 columns or rows.
/// @throws InvalidInput if the mesh has no extent or nothing is seen. Same bits for any number of threads.
[[nodiscard]] HeightField height_field(const Mesh& mesh, const RayScene& scene, const Vec3& viewer, double spacing_mm,
                                       const RunControl& control = {});

/// Mean curvature of a height function h toward the viewer,
///
///     ((1 + hx^2) hyy - 2 hx hy hxy + (1 + hy^2) hxx) / (2 (1 + hx^2 + hy^2)^1.5),
///
/// concave positive: a convex cap of radius R has -1/R, a pit 1/R, a cylinder -1/(2R), a plane 0 whatever its slope.
/// The derivatives are those of the quadric that fits the surroundings best under a Gaussian weight (least squares):
/// inside the surface exactly the derivatives of Gaussian-smoothed heights, and at borders and holes still exact for
/// quadrics, since what is not seen does not count.
/// @param width_mm  Standard deviation of the Gaussian; >= spacing_mm / 2. Not larger than half of the smallest feature
/// to keep.
/// @returns H x W, 1/mm; 0 outside `seen` and where too little is seen around for six coefficients.
/// @throws InvalidInput if the width is out of range. Cost: O(H W width_mm / spacing_mm).
[[nodiscard]] ImageF height_curvature(const HeightField& field, double width_mm, const RunControl& control = {});

/// Value of an image on the grid at a point: bilinear over the pixels that are seen; nothing where none of the four is.
[[nodiscard]] std::optional<double> sample_field(const HeightField& field, const ImageF& values, const Vec3& point);

}  // namespace patinate
