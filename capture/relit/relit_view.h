/// \file
/// What a camera sees of a scan, and the photographs of a moved object brought into the view of another step.
#pragma once

#include <span>
#include <vector>

#include "libcommon/geometry/ray_scene.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/camera.h"
#include "patinate/geometry/mesh.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// A pixel of a map of positions or normals.
[[nodiscard]] inline Vec3 pixel_vector(const ImageF& image, int x, int y) {
  const std::span<const float> v = image.pixel(x, y);
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}
inline void set_pixel_vector(ImageF& image, int x, int y, const Vec3& v) {
  for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(v[c]);
}

/// Maps of the camera's size; 0 where nothing is seen.
struct ScanView {
  ImageU8 seen;          ///< 255 where a pixel's center sees the mesh.
  ImageF position_mm;    ///< x 3, in the mesh's frame.
  ImageF normal;         ///< x 3, unit, toward the camera.
  ImageF texel_size_mm;  ///< Square root of the surface's area that a pixel shows.
  std::int64_t num_seen = 0;
  std::int64_t num_from_behind = 0;  ///< Pixels that see a triangle clockwise.
};

/// Casts a ray through every pixel's center. Positions lie on the triangles as they are.
/// @param mesh  In mm, with normals (normal_triangles). @param scene  Of it.
/// Same bits for any number of threads.
[[nodiscard]] ScanView view_scan(const Mesh& mesh, const RayScene& scene, const Camera& camera,
                                 const RunControl& control = {});

/// A scan's mesh with normals: those of the file, else angle-weighted ones, averaged `num_rounds` times over the
/// triangles around (by area), since a scanner's noise tilts triangles more than it moves points.
[[nodiscard]] Mesh with_scan_normals(Mesh mesh, int num_rounds = 2);

/// Where the pixels of the reference view lie in a step's photographs.
struct StepPlaces {
  ImageF place_px;  ///< x 2: column and row; only where `seen`.
  ImageU8 seen;     ///< 255 where the pixel nearest to the place of the surface is `whole`.
  /// Mask of the step's photographs: 255 where a pixel shows the surface and it alone, and so do the eight around;
  /// empty: all. Others have no part in a sample: one whose center lies on the object may have half of its area
  /// outside.
  ImageU8 whole = {};
  std::int64_t num_on_scan = 0;  ///< Reference pixels at whose place the step's scan is seen at all.
  double offset_mm = 0.0;  ///< Median distance of the reference surface from the step's scan there, along the normal.
};

/// Places of the reference's surface in a step: moved into the step's scanner frame and projected. A place is not seen
/// where the step's own scan hides it, where the scan is missing, or beside an outline, whose pixels show two surfaces.
/// @param reference  The reference step's view; @param step  the step's own, by the same camera.
[[nodiscard]] StepPlaces find_places(const ScanView& reference, const ScanView& step, const Camera& camera,
                                     const RigidTransform& step_from_reference, const RunControl& control = {});

/// A photograph in the reference view; and what of it counts.
struct PlacedPhoto {
  ImageF values;  ///< H x W x C; 0 where not valid.
  ImageU8 valid;  ///< 255 where the place is seen and none of the pixels that it is made of is saturated.
};
/// Samples are cubic between sixteen whole pixels, and bilinear between the whole ones of the nearest four where there
/// are not as many.
/// @param photo  Of 1 or 3 channels, >= 0. @param saturation  Value from which on a channel is saturated; infinity for
/// none.
[[nodiscard]] PlacedPhoto place_photo(const ImageF& photo, const StepPlaces& places, float saturation);

/// Adds to the deviation of albedo how far a sample may be off the value at the texel's center: a pixel shows the mean
/// over its area, between pixels more is lost (both by the second differences of the texels around), and beside an
/// outline samples come from the pixels of one side (by the first differences).
/// @param albedo  x 3. @param stddev  x 3; changed where `mask` has a texel.
void add_sampling_deviation(const ImageF& albedo, const ImageU8& mask, const StepPlaces& places, ImageF& stddev);

}  // namespace patinate::capture
