/// \file
/// What a photograph's pixels see of a scanned object: positions, normals, and how hard each place is to reach.
#pragma once

#include <optional>
#include <string>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/camera.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::capture {

struct ScanOptions {
  /// Gaussian width of what counts as one feature, as AccessibilityOptions::scale_mm. Not given: 2 % of the box's
  /// diagonal.
  std::optional<double> scale_mm;
};
void describe(OptionVisitor& v, ScanOptions& o);

/// Place of the photograph that each pixel of an image shows: x_photo = x0 + (x + 0.5) width / num_columns - 0.5, and
/// so in y. Pixel edges coincide, as when the part is averaged down.
struct PhotoPart {
  double x0 = 0.0;  ///< First pixel of the part, in the photograph.
  double y0 = 0.0;
  double width = 0.0;  ///< Pixels of the photograph; > 0.
  double height = 0.0;
  int num_columns = 0;  ///< Number of columns of the image; >= 1.
  int num_rows = 0;
  [[nodiscard]] double step_x() const { return width / num_columns; }
  [[nodiscard]] double step_y() const { return height / num_rows; }
  [[nodiscard]] Vec2 center(int column, int row) const {
    return {x0 + (column + 0.5) * step_x() - 0.5, y0 + (row + 0.5) * step_y() - 0.5};
  }
};

/// Maps of the image's size; 0 where the mesh is not seen.
struct ScanMaps {
  ImageU8 seen;             ///< 255 where a pixel's center sees the mesh.
  ImageF position_mm;       ///< x 3
  ImageF normal;            ///< x 3, unit, toward the camera.
  ImageF curvature_per_mm;  ///< Mean curvature at scale_mm, concave positive.
  ImageF texel_size_mm;     ///< Square root of the surface's area that a pixel shows.
  double scale_mm = 0.0;    ///< The one that was used.
  std::int64_t num_seen = 0;
};

/// Casts a ray through every pixel's center. The mesh is that of accessible_surface(): refined where its edges are
/// longer than half the scale, curved as its normals ask for. The side that the camera sees counts as the outside,
/// however the triangles are wound.
/// @param mesh_mm  In mm, as the camera. @throws InvalidInput if the mesh has no area.
/// Same bits for any number of threads.
[[nodiscard]] ScanMaps scan_maps(const Mesh& mesh_mm, const Camera& camera_mm, const PhotoPart& part,
                                 const ScanOptions& options = {}, const RunControl& control = {});

/// Where the camera has the middle of a mesh that it does not see, in words, for messages.
[[nodiscard]] std::string where_it_lies(const Mesh& mesh_mm, const Camera& camera_mm);

}  // namespace patinate::capture
