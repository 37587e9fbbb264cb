/// \file
/// Which texels a gammaton touches when it is wider than one texel, and what share of it lies on each.
#pragma once

#include <array>
#include <cstdint>

#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// A texel and its share of a gammaton, in 1/Splat::kWhole.
struct SplatPart {
  TexelIndex texel = 0;
  std::uint32_t share = 0;
};

/// Parts of one gammaton's splat; the first is the texel that was hit. Shares sum to kWhole.
struct Splat {
  static constexpr std::uint32_t kWhole = 4096;
  static constexpr int kMaxParts =
      64;  ///< Four steps in a plane reach 41; a surface may branch. What finds no place stays in the middle.

  std::array<SplatPart, kMaxParts> parts{};
  int num_parts = 0;
};

/// A splat `width` texels of median size wide: a lazy random walk (stay 1/2, 1/8 to each neighbor) over the surface,
/// across seams, as many steps as its radius has texels of the size hit, at most 4. Its shares are near a Gaussian,
/// alike in every chart whichever way it lies, and balanced: weight(a) share(a to b) = weight(b) share(b to a) up to
/// rounding, so that even rain makes even amounts, also where texels of two charts do not lie face to face. What would
/// walk off the surface's end stays.
/// @param width  1, 3 or 5.
[[nodiscard]] Splat splat_of(const SurfaceAtlas& surface, TexelIndex texel, int width);

}  // namespace patinate::simulation
