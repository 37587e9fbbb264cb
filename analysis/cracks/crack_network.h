/// \file
/// Cracks of a surface as a network: share, width, cells, and the angles at which cracks meet.
#pragma once

#include <optional>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::analysis {

/// Where cracks meet. Directions of three or more arms, degrees, ascending, in [0, 360).
struct CrackJunction {
  double x = 0.0, y = 0.0;  ///< Pixels.
  std::vector<double> arms_deg = {};

  /// The mean of all angles between neighboring arms but the largest, degrees: 90 where a crack ends on another or two
  /// cross, 120 where three meet evenly.
  [[nodiscard]] double angle_deg() const;
};

/// A piece of the surface between center lines.
struct CrackCell {
  double x = 0.0, y = 0.0;  ///< Its center, pixels.
  double area_px = 0.0;
};

/// A crack from one junction or end to the next.
struct CrackSegment {
  double x = 0.0, y = 0.0;  ///< Its middle, pixels.
  double chord_px = 0.0;    ///< From end to end.
  double waviness = 0.0;    ///< Root mean square distance from the chord, as a share of it: 0 = straight; an arc of a
                            ///< sixth of a circle has 0.098.
};

struct CrackNetwork {
  double share = 0.0;                         ///< Share of the surface.
  double area_px = 0.0;                       ///< Area of the cracks.
  double length_px = 0.0;                     ///< Length of the center lines.
  std::vector<CrackCell> cells = {};          ///< Those that touch neither border nor outside.
  std::vector<CrackJunction> junctions = {};  ///< Those whose arms can be followed without meeting another junction.

  std::vector<CrackSegment> segments = {};  ///< Those at least twice as long as an arm.

  /// Mean; nothing without cracks.
  [[nodiscard]] std::optional<double> width_px() const {
    return length_px > 0.0 ? std::optional(area_px / length_px) : std::nullopt;
  }
};

/// @param cracks  H x W, not 0 = crack. @param mask  H x W, 0 = outside; may be empty.
/// @param arm_px  Distance from a junction at which its arms' directions are taken, [3, 1000]: beyond the width of
/// cracks, below the size of cells.
/// @throws InvalidInput if sizes differ, the mask is empty everywhere or arm_px is out of range.
[[nodiscard]] CrackNetwork measure_cracks(const ImageU8& cracks, const ImageU8& mask, double arm_px);

}  // namespace patinate::analysis
