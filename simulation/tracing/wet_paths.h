/// \file
/// Wet paths attract drops: to which side of its way a floating gammaton turns.
#pragma once

#include <cmath>

#include "patinate/simulation/material_atlas.h"
#include "simulation/tracing/triangle_frames.h"

namespace patinate::simulation {

/// Where it is wet, and how strongly that attracts. What it reads does not change while drops respond, so that their
/// order does not matter.
struct WetPaths {
  static constexpr double kDry = 0.05;  ///< Amounts well below that attract little: less than a film.

  const MaterialAtlas* atlas = nullptr;
  int material = 0;
  double weight = 0.0;    ///< TracingOptions::wet_attraction.
  double width_mm = 0.0;  ///< TracingOptions::rivulet_mm.

  /// Tangent of the angle by which a drop turns toward `side`, [-weight, weight]: the difference of what is wet within
  /// half a width on both sides of it, over their sum.
  /// @param side  Unit, tangential, at right angles to its way.
  [[nodiscard]] double turn(const TriangleFrames& frames, const SurfacePlace& at, const Vec3& side) const {
    const Vec2 step = frames.weights_of(at.triangle, 0.25 * width_mm * side);
    if (!(step.cwiseAbs().maxCoeff() < 1e6)) return 0.0;  // a triangle without an area
    const auto wet = [&](double steps) {
      const TexelIndex texel =
          atlas->surface().texel_of(at.triangle, at.b1 + steps * step.x(), at.b2 + steps * step.y());
      return texel == kNoTexel ? 0.0 : static_cast<double>(atlas->amount(material, texel)) / kAmountOne;
    };
    const double there = wet(1.0) + wet(2.0), away = wet(-1.0) + wet(-2.0);
    return weight * (there - away) / (there + away + kDry);
  }
};

}  // namespace patinate::simulation
