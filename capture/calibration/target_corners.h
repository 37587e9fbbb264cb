/// \file
/// Points of a calibration target in a photograph (OpenCV inside).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// A flat target, or points of any shape.
struct CalibrationTarget {
  enum class Kind {
    Chessboard,  ///< Inner corners, row by row.
    Circles,     ///< Asymmetric grid of dark circles: every other row is shifted by half a step.
    Points,      ///< Given; not found in photographs.
  };
  Kind kind = Kind::Points;
  int columns = 0;  ///< Inner corners, or circles of a row; [2, 200].
  int rows = 0;
  double spacing_mm =
      0.0;  ///< Side of a square; for circles, distance of neighboring rows (half that of neighbors in a row); > 0.
  std::vector<Vec3> points_mm;  ///< Of Points.

  /// Its points in its own frame, z = 0 for the two flat kinds. @throws InvalidInput if a number is out of range.
  [[nodiscard]] std::vector<Vec3> points() const;
  /// "chessboard of 9 x 6 inner corners".
  [[nodiscard]] std::string text() const;
};

/// Pixels of target.points(), in their order, to a fraction of a pixel; nothing when the whole target is not seen.
/// A symmetric board may be found turned by half.
/// @param gray  H x W x 1, [0, 1], as encoded by the camera rather than linear: corners lie then in the middle of their
/// edges' codes.
[[nodiscard]] std::optional<std::vector<Vec2>> find_target(const ImageF& gray, const CalibrationTarget& target);

}  // namespace patinate::capture
