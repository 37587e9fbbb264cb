/// \file
/// Places in the source to fractions of a pixel, and how they go from a coarse level to a fine one.
#pragma once

#include <cstdint>
#include <vector>

#include "transfer/synthesis/energy.h"

namespace patinate {

/// A place in the source. Where texels are turned or scaled against it, a copied piece keeps its shape only if fractions are carried on from texel to texel.
struct Place {
  std::int32_t pixel = -1;        ///< y * width + x of the nearest pixel; -1 = none.
  std::int8_t rest_x = 0, rest_y = 0;  ///< Beside its middle, in 1/256 pixel.
};

/// Of all texels.
struct PlaceMap {
  CoordinateMap pixels;
  std::vector<std::int8_t> rests;  ///< x and y of each.

  explicit PlaceMap(std::int64_t num_texels) : pixels(static_cast<std::size_t>(num_texels), -1), rests(2 * static_cast<std::size_t>(num_texels)) {}
  [[nodiscard]] Place at(TexelId t) const {
    const auto i = static_cast<std::size_t>(t);
    return {pixels[i], rests[2 * i], rests[2 * i + 1]};
  }
  void set(TexelId t, const Place& place) {
    const auto i = static_cast<std::size_t>(t);
    pixels[i] = place.pixel;
    rests[2 * i] = place.rest_x;
    rests[2 * i + 1] = place.rest_y;
  }
};

/// In 1/256 pixel; middles of pixels are multiples of 256.
struct FixedPoint {
  std::int64_t x = 0, y = 0;
};
[[nodiscard]] FixedPoint fixed_point(const SourceLevel& source, const Place& place);
/// Pixel -1 where no usable pixel is.
[[nodiscard]] Place place_at(const SourceLevel& source, const FixedPoint& p);

inline constexpr int kSimilarTolerance = kControlSteps / 50;  ///< How near "similar control value" is.

/// Every covered texel gets a source pixel of similar control value.
[[nodiscard]] PlaceMap initial_places(const SynthesisLevel& level, std::uint64_t seed);

/// Doubles places: a fine texel's place lies in its parent's as the texel lies in its parent on the surface. Texels whose parent is not covered or leads outside take a
/// pixel of similar control value.
[[nodiscard]] PlaceMap upsample(const PlaceMap& coarse, const SynthesisLevel& coarse_level, const SynthesisLevel& fine_level, std::uint64_t seed);

}  // namespace patinate
