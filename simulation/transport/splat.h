/// \file
/// Which texels a gammaton touches when it is wider than one texel, and what share of it lies on each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "patinate/simulation/surface_atlas.h"
#include "simulation/transport/transfer.h"

namespace patinate::simulation {

/// A texel and its share of a gammaton, in 1/SplatShape::kWhole.
struct SplatPart {
  TexelIndex texel = 0;
  std::uint32_t share = 0;
};

/// A splat away from seams.
struct SplatStencil {
  struct Part {
    std::int8_t x = 0, y = 0;  ///< Texels from the middle.
    std::uint32_t share = 0;
  };
  int reach = 0;            ///< Texels that it goes to each side.
  std::vector<Part> parts;  ///< The middle first.

  /// Lanes: the same parts row by row, whole blocks of them for kernels (splat_kernel.h).
  struct Run {
    std::int8_t x = 0, y = 0;  ///< Offset of its first texel.
    std::uint8_t length = 0;   ///< Texels beside each other, each a lane.
  };
  std::vector<Run> runs;
  int num_lanes = 0;                         ///< With those behind the last part.
  int middle = 0;                            ///< Lane.
  std::vector<std::uint16_t> lane_of;        ///< By part.
  std::vector<std::uint32_t> number;         ///< By lane: of its part.
  std::vector<std::uint32_t> before, after;  ///< By lane: shares of all parts before this one; with this one.

  /// Makes the lanes of the parts.
  void lay_lanes();
};

/// How gammatons of one width lie on the surface: near a Gaussian whose standard deviation is a sixth of the width,
/// alike in every chart whichever way it lies, across seams. It is what a random walk from texel to texel leaves:
/// away from seams one of a few stencils, near them the walk itself. Balanced: weight(a) share(a to b) = weight(b)
/// share(b to a) up to rounding, so that even rain makes even amounts, also where texels of two charts do not lie face
/// to face. What would walk off the surface's end stays.
class SplatShape {
 public:
  /// Shares of a splat sum to it (docs/algorithms/material_exchange.md).
  static constexpr std::uint32_t kWhole = 65536;
  static constexpr std::size_t kMaxParts = 720;  ///< See docs/algorithms/material_exchange.md, Splats.
  static constexpr double kWidest = 33.0;        ///< Texels of the size that is hit: wider ones are cut to that.

  /// @param surface  Outlives it.
  /// @param width    In texels of median size; > 0.
  SplatShape(const SurfaceAtlas& surface, double width);

  [[nodiscard]] double width() const { return width_; }
  /// Appends the parts of a splat in the middle of a texel, that one first; shares sum to kWhole, none is 0.
  /// @returns how many they are, at most kMaxParts.
  std::size_t append(TexelIndex texel, std::vector<SplatPart>& parts) const;
  /// Asks memory for what append() will read there.
  void prefetch(TexelIndex texel) const;

  /// Size that append() uses. The variance along an axis, texels^2 of the size that is hit there, in 1/kVarianceOne;
  /// 0 = one texel.
  [[nodiscard]] int size_at(TexelIndex texel) const {
    return size_of(surface_->weight_of_triangle(surface_->triangle(texel)));
  }
  /// Size for texels of an area weight.
  [[nodiscard]] int size_of(std::uint32_t weight) const;
  /// Stencil of a variance.
  [[nodiscard]] static const SplatStencil& stencil_of(int size);
  /// Whether a stencil is what append() lays there: no seam and no end of the surface is near.
  [[nodiscard]] bool is_plain(int x, int y, int reach) const;
  /// A stencil's share where areas differ: no more than comes back from there.
  [[nodiscard]] static std::uint32_t balanced(std::uint32_t share, std::uint32_t weight, std::uint32_t other) {
    return transfer_kernel::balanced_share(share, weight, other);
  }

 private:
  [[nodiscard]] bool append_stencil(TexelIndex texel, int size, std::vector<SplatPart>& parts) const;

  const SurfaceAtlas* surface_;
  double width_;
};

}  // namespace patinate::simulation
