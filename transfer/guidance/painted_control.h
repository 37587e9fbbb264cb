/// \file
/// Strokes that change a control on a surface, as paint does.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"

namespace patinate::transfer {

/// A brush that is held at points of a surface, one after the other. Held twice at a place, it paints twice as long.
struct BrushStroke {
  std::vector<std::array<double, 3>> points_mm;  ///< At least one, in the coordinates of the surface.
  double radius_mm = 1.0;                        ///< > 0. Where the brush ends.
  double flow = 1.0;                             ///< (0, 1]. Share of the way to the brush's value in its middle.
};

/// What a stroke that reaches no texel is told.
[[nodiscard]] std::string unreached_text(const BrushStroke& stroke);

/// A texel that a stroke has reached.
struct BrushedTexel {
  TexelId texel = -1;
  double kept = 1.0;  ///< Share of what was there; the rest is the brush's value.
};

/// The value that a texel has after a stroke.
[[nodiscard]] constexpr double brushed(double before, double value, double kept) {
  return value + kept * (before - value);
}

/// Finds texels around points. Thread-safe.
class SurfaceBrush {
 public:
  /// @param map  Must outlive this. O(texels).
  explicit SurfaceBrush(const TexelMap& map, const RunControl& control = {});
  /// kept = product over points of 1 - flow (1 - d^2 / radius^2)^2, with d the straight distance to the point. The
  /// brush paints the side that it is held at: texels whose normal points away from that of the surface at a point are
  /// not reached from there. Ascending; only texels with kept < 1.
  [[nodiscard]] std::vector<BrushedTexel> find(const BrushStroke& stroke, const RunControl& control = {}) const;

 private:
  /// Texels that lie together, and the box around them.
  struct Square {
    TexelRect texels;
    Vec3 low, high;
  };
  static constexpr int kSquare = 32;  ///< Texels.

  struct Reached {
    TexelId texel;
    double squared_mm;
  };
  [[nodiscard]] std::vector<Reached> around(const Vec3& point, double radius_mm) const;
  /// Of the texels that are about as near to a point as the nearest, the one in whose plane it lies best: centers of
  /// the other side of a thin sheet may be nearer.
  [[nodiscard]] TexelId side_of(const Vec3& point, const std::vector<Reached>& reached) const;

  const TexelMap& map_;
  std::vector<Square> squares_;  ///< Those with covered texels.
};

}  // namespace patinate::transfer
