/// \file
/// Places in the source to fractions of a pixel, and how they go from a coarse level to a fine one.
#pragma once

#include <cstdint>
#include <vector>

#include "transfer/synthesis/energy.h"

namespace patinate {

/// In 1/256 pixel; middles of pixels are multiples of 256. A source is at most kLargestSource_px wide and high.
struct FixedPoint {
  std::int32_t x = 0, y = 0;
  friend bool operator==(const FixedPoint&, const FixedPoint&) = default;
};
inline constexpr int kLargestSource_px = 4'000'000;

/// A place in the source. Where texels are turned or scaled against it, a copied piece keeps its shape only if fractions are carried on from texel to texel.
struct Place {
  std::int32_t pixel = -1;  ///< y * width + x of the nearest pixel; -1 = none.
  FixedPoint point;
  friend bool operator==(const Place&, const Place&) = default;
};

/// Of all texels.
struct PlaceMap {
  CoordinateMap pixels;
  std::vector<FixedPoint> points;  ///< Where `pixels` are not -1.

  explicit PlaceMap(std::int64_t num_texels) : pixels(static_cast<std::size_t>(num_texels), -1), points(static_cast<std::size_t>(num_texels)) {}
  [[nodiscard]] Place at(TexelId t) const { return {pixels[static_cast<std::size_t>(t)], points[static_cast<std::size_t>(t)]}; }
  void set(TexelId t, const Place& place) {
    pixels[static_cast<std::size_t>(t)] = place.pixel;
    points[static_cast<std::size_t>(t)] = place.point;
  }
};

/// The middle of a pixel.
[[nodiscard]] inline Place place_of(const SourceLevel& source, std::int32_t pixel) {
  return {pixel, {pixel % source.width() * PixelNeighbor::kOne, pixel / source.width() * PixelNeighbor::kOne}};
}
/// Pixel -1 where no usable pixel is.
[[nodiscard]] inline Place place_at(const SourceLevel& source, const FixedPoint& p) {
  const std::int32_t x = whole_pixels(p.x), y = whole_pixels(p.y);
  if (x < 0 || y < 0 || x >= source.width() || y >= source.height()) return {};
  const std::int32_t pixel = y * source.width() + x;
  if (source.is_usable[static_cast<std::size_t>(pixel)] == 0) return {};
  return {pixel, p};
}

inline constexpr int kSimilarTolerance = kControlSteps / 50;  ///< How near "similar control value" is.

/// Every covered texel gets a source pixel of similar control value.
[[nodiscard]] PlaceMap initial_places(const SynthesisLevel& level, std::uint64_t seed);

/// Doubles places: a fine texel's place lies in its parent's as the texel lies in its parent on the surface. Texels whose parent is not covered or leads outside take a
/// pixel of similar control value.
[[nodiscard]] PlaceMap upsample(const PlaceMap& coarse, const SynthesisLevel& coarse_level, const SynthesisLevel& fine_level, std::uint64_t seed);

}  // namespace patinate
