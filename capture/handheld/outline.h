/// \file
/// Photographs of one object laid over one another by its outline: for what has no detail that stays.
#pragma once

#include <vector>

#include "capture/handheld/photo_pair.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// The outer border of an object, evenly spaced along it.
struct PhotoOutline {
  int width = 0;  ///< Width of the photograph.
  int height = 0;
  std::vector<Eigen::Vector2d> points = {};   ///< Pixels of the photograph. None: there is no object that stands out.
  std::vector<Eigen::Vector2d> normals = {};  ///< Unit.
  double size_px = 0.0;                       ///< Square root of the area within.
  double error_px = 1.0;                      ///< Error of a point, along its normal.
  /// A hole through the object: what the outline of a plate does not show, which of its turns is right.
  struct Hole {
    Eigen::Vector2d middle;
    double size_px = 0.0;  ///< Square root of its area.
  };
  std::vector<Hole> holes = {};
};

/// Outline of the largest connected part, and of its round holes. Where that touches the photograph's border its
/// outline is not known and is left out.
/// @param object  Reduced by any factor: 0 = not the object. @param width,height  Of the photograph.
[[nodiscard]] PhotoOutline find_outline(const ImageU8& object, int width, int height);

/// A similarity from outlines: from 72 turns of `a` around the middle of `b`, points go to the lines along the nearest
/// points of `b` [Chen and Medioni 1992], the farthest fifth left out: what has grown or broken off.
///
/// Accepted when at least 70 % of both outlines then lie within 1.5 % of the object's size of one another, and no other
/// turn (by more than 15 degrees) fits half as well with as many holes in place: of a disk, an ellipse or a square
/// without holes the turn cannot be known. Where one of both shows a hole, one must be in place.
[[nodiscard]] PhotoPair align_outlines(int a, const PhotoOutline& of_a, int b, const PhotoOutline& of_b);

}  // namespace patinate::capture
