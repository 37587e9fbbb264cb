/// \file
/// How far cracks and edges of a layer relieve the stress at a place.
#pragma once

#include <array>

#include "patinate/simulation/layer_atlas.h"
#include "simulation/layers/chart_walk.h"

namespace patinate::simulation {

/// Shares of the stress that are gone at a place, along two axes at right angles: less than 0 along one in which the
/// tension is larger than the stress (LayerCracks::tension).
struct Relief {
  SurfaceVector across{1.0F, 0.0F};  ///< Unit: the axis along which most is gone; a crack runs along it.
  float most = 0.0F;                 ///< Along that axis,
  float least = 0.0F;                ///< and along the other one, where tension is largest.
  float nearest = 0.0F;              ///< Of the one crack or edge that takes most, if it were alone.
};

/// The length over which a crack relieves a layer, mm: LayerCracks::relief times its thickness there, and at least
/// kLeastTexels texels, since cracks lie no closer than an atlas can show.
[[nodiscard]] double relief_length_mm(const LayerAtlas& layers, int layer, TexelIndex texel);
inline constexpr double kLeastTexels = 3.0;

/// How far a crack is open: twice the relief length, over which the layer draws back on either side, times its strain.
[[nodiscard]] double crack_width_mm(const LayerAtlas& layers, int layer, TexelIndex texel);

/// How far a texel without adhesion of a layer that cracks is lifted, mm: x^2 / 2R at the distance x from where the
/// layer still holds, and at most x / 2, where its edge rises by 45 degrees. Its upper side has shrunk by the layer's
/// strain and its lower side has not, so that R is thickness over strain. Texels farther than kLiftTexels from there,
/// in their own chart, count as that far.
[[nodiscard]] double lift_mm(const LayerAtlas& layers, int layer, TexelIndex texel);
inline constexpr int kLiftTexels = TileGrid::kTileSide;

/// Relief by shear lag. What lies at the distance D takes a = exp(-D / length) of the stress along its normal n and
/// a (n . u)^2 along an axis u; two on either side of a place take (a + b) / (1 + a b) together [Xia and Hutchinson
/// 2000; Cox 1952]. Cracks and edges are found by 16 rays.
/// @param ahead  Not nullptr: of what lies behind this direction nothing counts.
[[nodiscard]] Relief relief_at(const LayerAtlas& layers, int layer, TexelIndex texel, std::array<float, 2> place,
                               double length_mm, const SurfaceVector* ahead = nullptr);

}  // namespace patinate::simulation
