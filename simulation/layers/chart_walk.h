/// \file
/// A straight way over a surface, texel by texel and across seams.
#pragma once

#include <array>

#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// Two numbers along a texel's row and at right angles to it, on the surface.
using SurfaceVector = std::array<float, 2>;

/// Within a chart the way is straight in the atlas, as in a surface that is rolled out. Over a seam it goes on in the
/// plane of the triangle behind it, as if the two were rolled out together.
class ChartWalk {
 public:
  /// @param surface  Outlives it. @param texel  Covered. @param place  In the atlas, texels. @param way  Unit.
  ChartWalk(const SurfaceAtlas& surface, TexelIndex texel, std::array<float, 2> place, SurfaceVector way);

  /// Moves to a texel beside. @returns false where the surface ends.
  [[nodiscard]] bool advance();

  [[nodiscard]] TexelIndex texel() const { return texel_; }
  [[nodiscard]] const std::array<float, 2>& place() const { return place_; }
  [[nodiscard]] const SurfaceVector& way() const { return way_; }
  /// Length of the next step.
  [[nodiscard]] float step_mm() const { return step_mm_; }
  /// The two texels between which the last step led diagonally; kNoTexel otherwise.
  [[nodiscard]] const std::array<TexelIndex, 2>& beside() const { return beside_; }

 private:
  void find_step();
  [[nodiscard]] bool is_in_chart(int x, int y) const;
  [[nodiscard]] bool cross(std::size_t neighbor);

  const SurfaceAtlas* surface_;
  TexelIndex texel_;
  int triangle_;
  std::array<float, 2> place_;
  SurfaceVector way_;
  std::array<float, 2> step_{};  ///< Texels.
  float step_mm_ = 0.0F;
  std::array<TexelIndex, 2> beside_{kNoTexel, kNoTexel};
};

}  // namespace patinate::simulation
